// SPDX-License-Identifier: BSD-3-Clause
// Express capsules: 16 cabins of two samples in 5 bytes.
#include "drivers/lidar/codec/rplidar_capsules.hpp"

namespace slam::rplidar {
namespace {

constexpr std::size_t kCabinSize = 5;
constexpr int kTurnQ6 = 360 * 64;

}  // namespace

std::array<std::uint8_t, kExpressCapsuleSize> encodeExpressCapsule(const ExpressCapsule& capsule) {
  std::array<std::uint8_t, kExpressCapsuleSize> bytes{};
  for (std::size_t cabin = 0; cabin < kExpressSamples / 2; ++cabin) {
    const auto &first = capsule.samples[2 * cabin], &second = capsule.samples[2 * cabin + 1];
    const int word1 = first.distance_mm << 2 | (first.offset_q3 >> 4 & 3);
    const int word2 = second.distance_mm << 2 | (second.offset_q3 >> 4 & 3);
    std::uint8_t* out = bytes.data() + kCapsuleHeadSize + cabin * kCabinSize;
    out[0] = static_cast<std::uint8_t>(word1);
    out[1] = static_cast<std::uint8_t>(word1 >> 8);
    out[2] = static_cast<std::uint8_t>(word2);
    out[3] = static_cast<std::uint8_t>(word2 >> 8);
    out[4] = static_cast<std::uint8_t>((first.offset_q3 & 0x0F) | (second.offset_q3 & 0x0F) << 4);
  }
  sealCapsule({capsule.start_angle_q6, capsule.start}, bytes);
  return bytes;
}

std::optional<ExpressCapsule> parseExpressCapsule(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kExpressCapsuleSize) return std::nullopt;
  const auto head = parseCapsuleHead(bytes);
  if (!head) return std::nullopt;
  ExpressCapsule capsule{.start_angle_q6 = head->start_angle_q6, .start = head->start};
  for (std::size_t cabin = 0; cabin < kExpressSamples / 2; ++cabin) {
    const std::uint8_t* in = bytes.data() + kCapsuleHeadSize + cabin * kCabinSize;
    const int word1 = in[0] | in[1] << 8, word2 = in[2] | in[3] << 8;
    capsule.samples[2 * cabin] = {static_cast<std::uint16_t>(word1 >> 2),
                                  static_cast<std::uint8_t>((word1 & 3) << 4 | (in[4] & 0x0F))};
    capsule.samples[2 * cabin + 1] = {static_cast<std::uint16_t>(word2 >> 2),
                                      static_cast<std::uint8_t>((word2 & 3) << 4 | in[4] >> 4)};
  }
  return capsule;
}

std::array<Node, kExpressSamples> decodeExpress(const ExpressCapsule& capsule, std::uint16_t next_start_angle_q6) {
  const CapsuleSpan span(capsule.start_angle_q6, next_start_angle_q6, kExpressSamples);
  std::array<Node, kExpressSamples> nodes;
  for (int k = 0; k < kExpressSamples; ++k) {
    const RawAngle raw = span.at(k);
    const auto& sample = capsule.samples[static_cast<std::size_t>(k)];
    const int angle_q6 = (raw.q16 >> 10) - sample.offset_q3 * 8;  // 1/8 deg = 8/64
    nodes[static_cast<std::size_t>(k)] = {.angle_q6 = static_cast<std::uint16_t>((angle_q6 + kTurnQ6) % kTurnQ6),
                                          .distance_q2 = static_cast<std::uint32_t>(sample.distance_mm) << 2,
                                          .quality = sample.distance_mm > 0 ? kCapsuleQuality : std::uint8_t{0},
                                          .start = raw.start};
  }
  return nodes;
}

}  // namespace slam::rplidar
