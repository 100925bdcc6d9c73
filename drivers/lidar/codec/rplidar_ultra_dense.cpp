// SPDX-License-Identifier: BSD-3-Clause
// Ultra-dense capsules: 32 cabins of two samples of 20 bits, whose distance has four scales.
#include <algorithm>
#include <iterator>

#include "drivers/lidar/codec/rplidar_capsules.hpp"

namespace slam::rplidar {
namespace {

constexpr std::size_t kHeadSize = 10, kDenseCabinSize = 5;  // [bytes]
constexpr int kMostQuality = 255;

/// How the low two bits of a sample let the others be read: distance [mm * 4] = base + step * (bits below `quality`).
struct Scale {
  std::uint32_t base_q2, step;
  int quality;  // its first bit; the quality's low bits are lost
};
constexpr Scale kScales[] = {{0, 2, 12}, {4 * 2046, 3, 13}, {4 * 8187, 4, 14}, {4 * 24567, 5, 15}};

constexpr std::uint32_t distanceBits(const Scale& scale) { return (1U << scale.quality) - 4; }
constexpr std::uint32_t longestQ2(const Scale& scale) { return scale.base_q2 + scale.step * distanceBits(scale); }

}  // namespace

UltraDenseCapsule::Sample decodeUltraDenseSample(std::uint32_t bits) {
  const std::size_t index = bits & 3;
  const Scale& scale = kScales[index];
  return {scale.base_q2 + scale.step * (bits & distanceBits(scale)),
          static_cast<std::uint8_t>(bits >> scale.quality << index)};
}

std::uint32_t encodeUltraDenseSample(const UltraDenseCapsule::Sample& sample) {
  std::uint32_t index = 0;
  while (index + 1 < std::size(kScales) && sample.distance_q2 > longestQ2(kScales[index])) ++index;
  const Scale& scale = kScales[index];
  const std::uint32_t unit = 4 * scale.step;  // the two lowest bits are the scale's
  const std::uint32_t above = std::min(sample.distance_q2, longestQ2(scale)) - scale.base_q2;
  const std::uint32_t quality = static_cast<std::uint32_t>(sample.quality & kMostQuality) >> index;
  return quality << scale.quality | (above + unit / 2) / unit << 2 | index;
}

std::array<std::uint8_t, kUltraDenseCapsuleSize> encodeUltraDenseCapsule(const UltraDenseCapsule& capsule) {
  std::array<std::uint8_t, kUltraDenseCapsuleSize> bytes{};
  for (std::size_t cabin = 0; cabin < kUltraDenseSamples / 2; ++cabin) {
    const std::uint32_t first = encodeUltraDenseSample(capsule.samples[2 * cabin]),
                        second = encodeUltraDenseSample(capsule.samples[2 * cabin + 1]);
    std::uint8_t* out = bytes.data() + kHeadSize + cabin * kDenseCabinSize;
    out[0] = static_cast<std::uint8_t>(first);
    out[1] = static_cast<std::uint8_t>(first >> 8);
    out[2] = static_cast<std::uint8_t>(second);
    out[3] = static_cast<std::uint8_t>(second >> 8);
    out[4] = static_cast<std::uint8_t>(first >> 16 | second >> 16 << 4);
  }
  sealCapsule({capsule.start_angle_q6, capsule.start}, bytes, kUltraDenseAngleAt);
  return bytes;
}

std::optional<UltraDenseCapsule> parseUltraDenseCapsule(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kUltraDenseCapsuleSize) return std::nullopt;
  const auto head = parseCapsuleHead(bytes, kUltraDenseAngleAt);
  if (!head) return std::nullopt;
  UltraDenseCapsule capsule{.start_angle_q6 = head->start_angle_q6, .start = head->start};
  for (std::size_t cabin = 0; cabin < kUltraDenseSamples / 2; ++cabin) {
    const std::uint8_t* in = bytes.data() + kHeadSize + cabin * kDenseCabinSize;
    const auto sample = [in](int low, int high) {
      return decodeUltraDenseSample(static_cast<std::uint32_t>(in[low] | in[low + 1] << 8 | high << 16));
    };
    capsule.samples[2 * cabin] = sample(0, in[4] & 0x0F);
    capsule.samples[2 * cabin + 1] = sample(2, in[4] >> 4);
  }
  return capsule;
}

std::array<Node, kUltraDenseSamples> decodeUltraDense(const UltraDenseCapsule& capsule,
                                                      std::uint16_t next_start_angle_q6) {
  const CapsuleSpan span(capsule.start_angle_q6, next_start_angle_q6, kUltraDenseSamples);
  std::array<Node, kUltraDenseSamples> nodes;
  for (int k = 0; k < kUltraDenseSamples; ++k) {
    const RawAngle raw = span.at(k);
    const auto& sample = capsule.samples[static_cast<std::size_t>(k)];
    nodes[static_cast<std::size_t>(k)] = {.angle_q6 = static_cast<std::uint16_t>(raw.q16 >> 10),
                                          .distance_q2 = sample.distance_q2,
                                          .quality = sample.distance_q2 > 0 ? sample.quality : std::uint8_t{0},
                                          .start = raw.start};
  }
  return nodes;
}

}  // namespace slam::rplidar
