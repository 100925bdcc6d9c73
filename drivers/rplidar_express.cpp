// SPDX-License-Identifier: BSD-3-Clause
// Express capsules: 2 check bytes, start angle with the S bit, 16 cabins of two samples in 5 bytes.
#include "drivers/rplidar_codec.hpp"

namespace slam::rplidar {
namespace {

constexpr std::uint8_t kFirstSync = 0xA0, kSecondSync = 0x50;
constexpr std::size_t kCabinsAt = 4, kCabinSize = 5;
constexpr int kTurnQ6 = 360 * 64;
constexpr std::uint8_t kQuality = 0x2F;  // capsules carry no quality; the vendor's SDK reports this for a valid sample

std::uint8_t capsuleChecksum(std::span<const std::uint8_t> bytes) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : bytes.subspan(2)) sum ^= byte;
  return sum;
}

}  // namespace

std::array<std::uint8_t, kExpressCapsuleSize> encodeExpressCapsule(const ExpressCapsule& capsule) {
  std::array<std::uint8_t, kExpressCapsuleSize> bytes{};
  const int start = capsule.start_angle_q6 | (capsule.start ? 0x8000 : 0);
  bytes[2] = static_cast<std::uint8_t>(start);
  bytes[3] = static_cast<std::uint8_t>(start >> 8);
  for (std::size_t cabin = 0; cabin < kExpressSamples / 2; ++cabin) {
    const auto &first = capsule.samples[2 * cabin], &second = capsule.samples[2 * cabin + 1];
    const int word1 = first.distance_mm << 2 | (first.offset_q3 >> 4 & 3);
    const int word2 = second.distance_mm << 2 | (second.offset_q3 >> 4 & 3);
    std::uint8_t* out = bytes.data() + kCabinsAt + cabin * kCabinSize;
    out[0] = static_cast<std::uint8_t>(word1);
    out[1] = static_cast<std::uint8_t>(word1 >> 8);
    out[2] = static_cast<std::uint8_t>(word2);
    out[3] = static_cast<std::uint8_t>(word2 >> 8);
    out[4] = static_cast<std::uint8_t>((first.offset_q3 & 0x0F) | (second.offset_q3 & 0x0F) << 4);
  }
  const std::uint8_t sum = capsuleChecksum(bytes);
  bytes[0] = static_cast<std::uint8_t>(kFirstSync | (sum & 0x0F));
  bytes[1] = static_cast<std::uint8_t>(kSecondSync | sum >> 4);
  return bytes;
}

std::optional<ExpressCapsule> parseExpressCapsule(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kExpressCapsuleSize) return std::nullopt;
  if ((bytes[0] & 0xF0) != kFirstSync || (bytes[1] & 0xF0) != kSecondSync) return std::nullopt;
  if (((bytes[0] & 0x0F) | (bytes[1] & 0x0F) << 4) != capsuleChecksum(bytes)) return std::nullopt;
  ExpressCapsule capsule;
  const int start = bytes[2] | bytes[3] << 8;
  capsule.start = start & 0x8000;
  capsule.start_angle_q6 = static_cast<std::uint16_t>((start & 0x7FFF) % kTurnQ6);
  for (std::size_t cabin = 0; cabin < kExpressSamples / 2; ++cabin) {
    const std::uint8_t* in = bytes.data() + kCabinsAt + cabin * kCabinSize;
    const int word1 = in[0] | in[1] << 8, word2 = in[2] | in[3] << 8;
    capsule.samples[2 * cabin] = {static_cast<std::uint16_t>(word1 >> 2),
                                  static_cast<std::uint8_t>((word1 & 3) << 4 | (in[4] & 0x0F))};
    capsule.samples[2 * cabin + 1] = {static_cast<std::uint16_t>(word2 >> 2),
                                      static_cast<std::uint8_t>((word2 & 3) << 4 | in[4] >> 4)};
  }
  return capsule;
}

std::array<Node, kExpressSamples> decodeExpress(const ExpressCapsule& capsule, std::uint16_t next_start_angle_q6) {
  int span = next_start_angle_q6 - capsule.start_angle_q6;
  if (span < 0) span += kTurnQ6;
  std::array<Node, kExpressSamples> nodes;
  for (int k = 0; k < kExpressSamples; ++k) {
    const auto& sample = capsule.samples[static_cast<std::size_t>(k)];
    Node& node = nodes[static_cast<std::size_t>(k)];
    const int raw = (capsule.start_angle_q6 + span * k / kExpressSamples) % kTurnQ6;
    const int next = capsule.start_angle_q6 + span * (k + 1) / kExpressSamples;
    // A turn begins at the sample whose raw angle is the last before the zero direction, before correction.
    node.start = next / kTurnQ6 > (capsule.start_angle_q6 + span * k / kExpressSamples) / kTurnQ6;
    node.angle_q6 = static_cast<std::uint16_t>((raw - sample.offset_q3 * 8 + kTurnQ6) % kTurnQ6);  // 1/8 deg = 8/64
    node.distance_q2 = static_cast<std::uint32_t>(sample.distance_mm) << 2;
    node.quality = sample.distance_mm > 0 ? kQuality : 0;
  }
  return nodes;
}

}  // namespace slam::rplidar
