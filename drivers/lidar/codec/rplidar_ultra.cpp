// SPDX-License-Identifier: BSD-3-Clause
// Ultra capsules: 32 cabins, each a u32 LE of 12 bits major and two signed predictions of 10 bits.
#include <algorithm>
#include <cstdlib>

#include "drivers/lidar/codec/rplidar_capsules.hpp"

namespace slam::rplidar {
namespace {

constexpr std::size_t kUltraCabinSize = 4;
constexpr int kUltraTurnQ6 = 360 * 64;
constexpr int kPredictMax = 510;  // +511 says no echo, too

/// Bands of the major scale: from `major` on, `mm` + (value - major) * 2^level.
struct Band {
  int major, mm, level;
};
constexpr std::array<Band, 5> kBands = {{{0, 0, 0}, {512, 512, 1}, {1280, 2048, 2}, {1792, 4096, 3}, {3328, 16384, 4}}};
constexpr int kMajorMax = 4095;

std::int16_t signed10(std::uint32_t bits) {
  return static_cast<std::int16_t>(static_cast<int>(bits & 0x3FF) - ((bits & 0x200) != 0 ? 0x400 : 0));
}

bool isEcho(int predict) { return predict != kNoPrediction && predict != 511; }

Node node(const RawAngle& raw, int distance_mm) {
  const std::uint32_t distance_q2 = distance_mm > 0 ? static_cast<std::uint32_t>(distance_mm) << 2 : 0;
  const int angle_q6 = (raw.q16 - ultraAngleOffsetQ16(distance_q2)) >> 10;
  return {.angle_q6 = static_cast<std::uint16_t>((angle_q6 + kUltraTurnQ6) % kUltraTurnQ6),
          .distance_q2 = distance_q2,
          .quality = distance_q2 > 0 ? kCapsuleQuality : std::uint8_t{0},
          .start = raw.start};
}

}  // namespace

ScaledDistance decodeMajor(std::uint16_t major) {
  const auto band = std::find_if(kBands.rbegin(), kBands.rend(), [&](const Band& b) { return major >= b.major; });
  return {band->mm + ((major - band->major) << band->level), band->level};
}

std::uint16_t encodeMajor(int mm) {
  const auto band = std::find_if(kBands.rbegin(), kBands.rend() - 1, [&](const Band& b) { return mm >= b.mm; });
  const int steps = (mm - band->mm + (1 << band->level >> 1)) >> band->level;
  return static_cast<std::uint16_t>(std::clamp(band->major + steps, 0, kMajorMax));
}

std::array<UltraCapsule::Cabin, kUltraCabins> encodeUltraCabins(std::span<const int, kUltraSamples> distances,
                                                                int next_first) {
  std::array<UltraCapsule::Cabin, kUltraCabins> cabins;
  const auto predict = [](int distance, const ScaledDistance& base) -> std::int16_t {
    if (distance <= 0) return kNoPrediction;
    const int difference = (distance - base.mm + (1 << base.level >> 1)) >> base.level;
    return static_cast<std::int16_t>(std::abs(difference) <= kPredictMax ? difference : kNoPrediction);
  };
  for (std::size_t i = 0; i < kUltraCabins; ++i) cabins[i].major = encodeMajor(distances[3 * i]);
  for (std::size_t i = 0; i < kUltraCabins; ++i) {
    const std::uint16_t next_major = i + 1 < kUltraCabins ? cabins[i + 1].major : encodeMajor(next_first);
    const ScaledDistance next = decodeMajor(next_major);
    const ScaledDistance base = cabins[i].major == 0 && next_major != 0 ? next : decodeMajor(cabins[i].major);
    cabins[i].predict1 = predict(distances[3 * i + 1], base);
    cabins[i].predict2 = predict(distances[3 * i + 2], next);
  }
  return cabins;
}

int ultraAngleOffsetQ16(std::uint32_t distance_q2) {
  // The device's own arithmetic, in radians * 65536 until the last step.
  constexpr double kPi = 3.1415926535;
  constexpr int kNear = static_cast<int>(7.5 * kPi / 180.0 * 65536.0),
                kFar = static_cast<int>(8.0 * kPi / 180.0 * 65536.0);
  int offset = kNear;
  if (distance_q2 >= 50 * 4) {
    const int k = static_cast<int>(98361 / distance_q2);
    offset = kFar - 64 * k - k * k * k / 98304;
  }
  return static_cast<int>(offset * 180.0 / kPi);
}

std::array<std::uint8_t, kUltraCapsuleSize> encodeUltraCapsule(const UltraCapsule& capsule) {
  std::array<std::uint8_t, kUltraCapsuleSize> bytes{};
  for (std::size_t i = 0; i < kUltraCabins; ++i) {
    const UltraCapsule::Cabin& cabin = capsule.cabins[i];
    const std::uint32_t word = (cabin.major & 0xFFFU) | (static_cast<std::uint32_t>(cabin.predict1) & 0x3FFU) << 12 |
                               (static_cast<std::uint32_t>(cabin.predict2) & 0x3FFU) << 22;
    for (std::size_t b = 0; b < kUltraCabinSize; ++b) {
      bytes[kCapsuleHeadSize + i * kUltraCabinSize + b] = static_cast<std::uint8_t>(word >> 8 * b);
    }
  }
  sealCapsule({capsule.start_angle_q6, capsule.start}, bytes);
  return bytes;
}

std::optional<UltraCapsule> parseUltraCapsule(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kUltraCapsuleSize) return std::nullopt;
  const auto head = parseCapsuleHead(bytes);
  if (!head) return std::nullopt;
  UltraCapsule capsule{.start_angle_q6 = head->start_angle_q6, .start = head->start};
  for (std::size_t i = 0; i < kUltraCabins; ++i) {
    const std::uint8_t* in = bytes.data() + kCapsuleHeadSize + i * kUltraCabinSize;
    const std::uint32_t word = in[0] | static_cast<std::uint32_t>(in[1]) << 8 |
                               static_cast<std::uint32_t>(in[2]) << 16 | static_cast<std::uint32_t>(in[3]) << 24;
    capsule.cabins[i] = {static_cast<std::uint16_t>(word & 0xFFF), signed10(word >> 12), signed10(word >> 22)};
  }
  return capsule;
}

std::array<Node, kUltraSamples> decodeUltra(const UltraCapsule& capsule, const UltraCapsule& next) {
  const CapsuleSpan span(capsule.start_angle_q6, next.start_angle_q6, kUltraSamples);
  std::array<Node, kUltraSamples> nodes;
  for (int i = 0; i < kUltraCabins; ++i) {
    const auto& cabin = capsule.cabins[static_cast<std::size_t>(i)];
    const auto& after = i + 1 < kUltraCabins ? capsule.cabins[static_cast<std::size_t>(i + 1)] : next.cabins[0];
    const ScaledDistance first = decodeMajor(cabin.major), third = decodeMajor(after.major);
    const ScaledDistance& base = cabin.major == 0 && after.major != 0 ? third : first;
    const auto predicted = [](const ScaledDistance& from, int predict) {
      return isEcho(predict) ? from.mm + predict * (1 << from.level) : 0;
    };
    const std::array<int, 3> distances = {first.mm, predicted(base, cabin.predict1), predicted(third, cabin.predict2)};
    for (int j = 0; j < 3; ++j) {
      nodes[static_cast<std::size_t>(3 * i + j)] = node(span.at(3 * i + j), distances[static_cast<std::size_t>(j)]);
    }
  }
  return nodes;
}

}  // namespace slam::rplidar
