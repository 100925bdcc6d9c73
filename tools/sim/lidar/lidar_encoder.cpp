// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/lidar_encoder.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/lidar/codec/rplidar_capsules.hpp"

namespace slam::sim {
namespace {

using rplidar::AnswerType;

constexpr std::uint8_t kUltraDenseQuality = 40;  // of an echo
constexpr double kEnough = 0.05;                 // [deg] a better guess of the angle is not worth another look

std::uint16_t angleQ6(double degrees) {
  return static_cast<std::uint16_t>(((std::lround(degrees * 64.0) % 23040) + 23040) % 23040);
}
int millimetres(double range, long most) { return static_cast<int>(std::clamp(std::lround(range * 1000.0), 0L, most)); }

template <std::size_t N>
std::vector<std::uint8_t> bytesOf(const std::array<std::uint8_t, N>& array) {
  return {array.begin(), array.end()};
}

}  // namespace

double LidarEncoder::offsetFor(double range) const {
  const auto distance_q2 = static_cast<std::uint32_t>(std::lround(range * 4000.0));
  const double offset = rplidar::ultraAngleOffsetQ16(distance_q2) / 65536.0;
  switch (type_) {
    case AnswerType::kDenseCapsules:
    case AnswerType::kUltraDenseCapsules:
      return 0.0;
    case AnswerType::kExpressCapsules:  // told in six bits of an eighth of a degree
      return range > 0.0 ? std::clamp(std::round(offset * 8.0), 0.0, 63.0) / 8.0 : 0.0;
    case AnswerType::kStandardNodes:  // a node without echo tells the raw angle
      return range > 0.0 ? offset : 0.0;
    default:
      return offset;
  }
}

LidarEncoder::Sample LidarEncoder::take(double raw, bool start, const Look& look) {
  double offset = offsetFor(last_range_);
  double range = look(raw - offset);
  if (range > 0.0 && std::abs(offsetFor(range) - offset) > kEnough) {
    offset = offsetFor(range);
    range = look(raw - offset);
  }
  if (range <= 0.0) return {raw, offsetFor(range), 0.0, start};
  last_range_ = range;
  return {raw, offset, range, start};
}

std::vector<std::uint8_t> LidarEncoder::pack(const std::vector<Sample>& samples, bool s_bit) const {
  const std::uint16_t start = angleQ6(samples[0].raw);
  switch (type_) {
    case AnswerType::kExpressCapsules: {
      rplidar::ExpressCapsule capsule{.start_angle_q6 = start, .start = s_bit};
      for (std::size_t i = 0; i < capsule.samples.size(); ++i) {
        capsule.samples[i] = {static_cast<std::uint16_t>(millimetres(samples[i].range, 16383)),
                              static_cast<std::uint8_t>(std::lround(samples[i].offset * 8.0))};
      }
      return bytesOf(rplidar::encodeExpressCapsule(capsule));
    }
    case AnswerType::kUltraCapsules: {
      std::array<int, rplidar::kUltraSamples> distances;
      for (std::size_t i = 0; i < distances.size(); ++i) distances[i] = millimetres(samples[i].range, 28656);
      const int next_first = millimetres(samples[distances.size()].range, 28656);
      return bytesOf(rplidar::encodeUltraCapsule({start, s_bit, rplidar::encodeUltraCabins(distances, next_first)}));
    }
    case AnswerType::kDenseCapsules: {
      rplidar::DenseCapsule capsule{.start_angle_q6 = start, .start = s_bit};
      for (std::size_t i = 0; i < capsule.distances_mm.size(); ++i) {
        capsule.distances_mm[i] = static_cast<std::uint16_t>(millimetres(samples[i].range, 65535));
      }
      return bytesOf(rplidar::encodeDenseCapsule(capsule));
    }
    case AnswerType::kUltraDenseCapsules: {
      rplidar::UltraDenseCapsule capsule{.start_angle_q6 = start, .start = s_bit};
      for (std::size_t i = 0; i < capsule.samples.size(); ++i) {
        if (const int mm = millimetres(samples[i].range, 65522); mm > 0)
          capsule.samples[i] = {4U * static_cast<std::uint32_t>(mm), kUltraDenseQuality};
      }
      return bytesOf(rplidar::encodeUltraDenseCapsule(capsule));
    }
    default: {
      const Sample& sample = samples[0];
      return bytesOf(
          rplidar::encodeStandardNode({.angle_q6 = angleQ6(sample.raw - sample.offset),
                                       .distance_q2 = static_cast<std::uint32_t>(std::lround(sample.range * 4000.0)),
                                       .quality = static_cast<std::uint8_t>(sample.range > 0.0 ? 15 : 0),
                                       .start = sample.start}));
    }
  }
}

}  // namespace slam::sim
