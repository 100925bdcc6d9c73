// SPDX-License-Identifier: BSD-3-Clause
// Dense capsules: 40 distances of 16 bits.
#include "drivers/lidar/codec/rplidar_capsules.hpp"

namespace slam::rplidar {

std::array<std::uint8_t, kDenseCapsuleSize> encodeDenseCapsule(const DenseCapsule& capsule) {
  std::array<std::uint8_t, kDenseCapsuleSize> bytes{};
  for (std::size_t i = 0; i < kDenseSamples; ++i) {
    bytes[kCapsuleHeadSize + 2 * i] = static_cast<std::uint8_t>(capsule.distances_mm[i]);
    bytes[kCapsuleHeadSize + 2 * i + 1] = static_cast<std::uint8_t>(capsule.distances_mm[i] >> 8);
  }
  sealCapsule({capsule.start_angle_q6, capsule.start}, bytes);
  return bytes;
}

std::optional<DenseCapsule> parseDenseCapsule(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kDenseCapsuleSize) return std::nullopt;
  const auto head = parseCapsuleHead(bytes);
  if (!head) return std::nullopt;
  DenseCapsule capsule{.start_angle_q6 = head->start_angle_q6, .start = head->start};
  for (std::size_t i = 0; i < kDenseSamples; ++i) {
    const std::uint8_t* in = bytes.data() + kCapsuleHeadSize + 2 * i;
    capsule.distances_mm[i] = static_cast<std::uint16_t>(in[0] | in[1] << 8);
  }
  return capsule;
}

std::array<Node, kDenseSamples> decodeDense(const DenseCapsule& capsule, std::uint16_t next_start_angle_q6) {
  const CapsuleSpan span(capsule.start_angle_q6, next_start_angle_q6, kDenseSamples);
  std::array<Node, kDenseSamples> nodes;
  for (int k = 0; k < kDenseSamples; ++k) {
    const RawAngle raw = span.at(k);
    const std::uint16_t distance = capsule.distances_mm[static_cast<std::size_t>(k)];
    nodes[static_cast<std::size_t>(k)] = {.angle_q6 = static_cast<std::uint16_t>(raw.q16 >> 10),
                                          .distance_q2 = static_cast<std::uint32_t>(distance) << 2,
                                          .quality = distance > 0 ? kCapsuleQuality : std::uint8_t{0},
                                          .start = raw.start};
  }
  return nodes;
}

}  // namespace slam::rplidar
