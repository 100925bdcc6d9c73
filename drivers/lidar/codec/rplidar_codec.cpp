// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/rplidar_codec.hpp"

#include <algorithm>

namespace slam::rplidar {
namespace {

constexpr std::uint8_t kRequestSync = 0xA5, kAnswerSync = 0x5A;
constexpr std::uint32_t kLengthMask = 0x3FFFFFFF;
constexpr std::uint16_t kNodeTurnQ6 = 360 * 64;

using Bytes = std::span<const std::uint8_t>;

std::uint16_t u16(Bytes bytes, std::size_t offset) {
  return static_cast<std::uint16_t>(bytes[offset] | bytes[offset + 1] << 8);
}

std::vector<std::uint8_t> encodeNumber(Request request, std::uint16_t number) {
  const std::array<std::uint8_t, 2> payload = {static_cast<std::uint8_t>(number & 0xFF),
                                               static_cast<std::uint8_t>(number >> 8)};
  return encodeRequest(request, payload);
}

}  // namespace

std::vector<std::uint8_t> encodeRequest(Request request, Bytes payload) {
  const auto command = static_cast<std::uint8_t>(request);
  std::vector<std::uint8_t> bytes = {kRequestSync, command};
  if ((command & 0x80) == 0) return bytes;
  bytes.push_back(static_cast<std::uint8_t>(payload.size()));
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : bytes) sum ^= byte;
  bytes.push_back(sum);
  return bytes;
}

std::vector<std::uint8_t> encodeExpressScan(std::uint8_t mode) {
  const std::array<std::uint8_t, 5> payload = {mode, 0, 0, 0, 0};
  return encodeRequest(Request::kExpressScan, payload);
}

std::vector<std::uint8_t> encodeMotorPwm(std::uint16_t pwm) { return encodeNumber(Request::kSetMotorPwm, pwm); }

std::vector<std::uint8_t> encodeMotorSpeed(std::uint16_t rpm) { return encodeNumber(Request::kSetMotorSpeed, rpm); }

std::array<std::uint8_t, kDescriptorSize> encodeDescriptor(const Descriptor& descriptor) {
  const std::uint32_t word = (descriptor.length & kLengthMask) | (descriptor.stream ? 1U << 30 : 0U);
  return {kRequestSync,
          kAnswerSync,
          static_cast<std::uint8_t>(word),
          static_cast<std::uint8_t>(word >> 8),
          static_cast<std::uint8_t>(word >> 16),
          static_cast<std::uint8_t>(word >> 24),
          descriptor.type};
}

std::optional<Descriptor> parseDescriptor(Bytes bytes) {
  if (bytes.size() != kDescriptorSize || bytes[0] != kRequestSync || bytes[1] != kAnswerSync) return std::nullopt;
  const std::uint32_t word = static_cast<std::uint32_t>(bytes[2]) | static_cast<std::uint32_t>(bytes[3]) << 8 |
                             static_cast<std::uint32_t>(bytes[4]) << 16 | static_cast<std::uint32_t>(bytes[5]) << 24;
  return Descriptor{word & kLengthMask, word >> 30 == 1, bytes[6]};
}

std::optional<DeviceInfo> parseInfo(Bytes data) {
  if (data.size() != 20) return std::nullopt;
  DeviceInfo info{.model = data[0], .firmware = u16(data, 1), .hardware = data[3]};
  std::copy(data.begin() + 4, data.end(), info.serial.begin());
  return info;
}

std::optional<Health> parseHealth(Bytes data) {
  if (data.size() != 3 || data[0] > 2) return std::nullopt;
  return Health{static_cast<HealthStatus>(data[0]), u16(data, 1)};
}

std::optional<SampleRate> parseSampleRate(Bytes data) {
  if (data.size() != 4) return std::nullopt;
  const SampleRate rate{u16(data, 0), u16(data, 2)};
  return rate.standard_us > 0 && rate.express_us > 0 ? std::optional(rate) : std::nullopt;
}

std::array<std::uint8_t, kStandardNodeSize> encodeStandardNode(const Node& node) {
  const auto distance = static_cast<std::uint16_t>(std::min<std::uint32_t>(node.distance_q2, 0xFFFF));
  return {static_cast<std::uint8_t>((node.quality & 0x3F) << 2 | (node.start ? 1 : 2)),
          static_cast<std::uint8_t>((node.angle_q6 & 0x7F) << 1 | 1), static_cast<std::uint8_t>(node.angle_q6 >> 7),
          static_cast<std::uint8_t>(distance & 0xFF), static_cast<std::uint8_t>(distance >> 8)};
}

std::optional<Node> parseStandardNode(Bytes bytes) {
  if (bytes.size() != kStandardNodeSize) return std::nullopt;
  const bool start = bytes[0] & 1, not_start = bytes[0] & 2;
  if (start == not_start || (bytes[1] & 1) == 0) return std::nullopt;
  Node node;
  node.start = start;
  node.quality = static_cast<std::uint8_t>(bytes[0] >> 2);
  node.angle_q6 = static_cast<std::uint16_t>((bytes[1] >> 1 | bytes[2] << 7) % kNodeTurnQ6);
  node.distance_q2 = u16(bytes, 3);
  return node;
}

}  // namespace slam::rplidar
