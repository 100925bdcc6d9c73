// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "tools/convert/formats.hpp"
#include "tools/convert/log_output.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

constexpr double kWheelRadius = 0.077, kHalfTrack = 0.165;  // [m]
constexpr double kTicksPerTurn = 2000.0;
constexpr double kLatest = 2.3e15, kMostTicks = 1e15;  // [us], [1]: more are none
constexpr std::size_t kFirstRange = 24, kBeams = 682, kMargin = 70;
constexpr double kFirstBearing = -2.0 * std::numbers::pi / 3.0;          // [rad] of beam 0: 240 deg in all
constexpr double kStep = (4.0 * std::numbers::pi / 3.0) / (kBeams - 1);  // [rad]

}  // namespace

Recording convertMines(const std::filesystem::path& in, const std::filesystem::path& out) {
  TextFile file(in);
  Recording recording;
  recording.format = "Mines ParisTech rover";
  recording.robot = {.lidar_x = 0.145,
                     .mount_source = "the description of this robot",
                     .range_min = 0.06,
                     .range_max = 4.0,
                     .range_sigma = 0.02,
                     .wheel_radius = kWheelRadius,
                     .half_track = kHalfTrack};
  SensorRows& rows = recording.sensor("lines of 706 numbers");
  LogOutput log;
  auto scan = std::make_unique<LaserScan>();
  scan->range_min = 0.06F;
  scan->range_max = 4.1F;
  Pose2 pose;
  double last_left = 0.0, last_right = 0.0;
  for (std::string line; file.next(line);) {
    const auto words = splitWords(line);
    if (words.empty()) continue;
    const auto numbers = words.size() >= kFirstRange + kBeams ? toNumbers(words) : std::nullopt;
    // [us]; slamd's messages carry no later times
    const bool timed = numbers && (*numbers)[0] >= 1.0 && (*numbers)[0] < kLatest;
    const double left = timed ? (*numbers)[2] : 0.0, right = timed ? (*numbers)[3] : 0.0;
    if (!timed || std::max(std::abs(left), std::abs(right)) > kMostTicks) {
      recording.reject(rows, in.filename().string() + ":" + std::to_string(file.lineNumber()),
                       "not 24 values and 682 ranges");
      continue;
    }
    const auto utime = static_cast<std::int64_t>((*numbers)[0]);
    if (recording.wheels > 0) {
      const double metres_per_tick = 2.0 * std::numbers::pi * kWheelRadius / kTicksPerTurn;
      const double travel_left = (left - last_left) * metres_per_tick;
      const double travel_right = (right - last_right) * metres_per_tick;
      pose = pose * exp({0.5 * (travel_left + travel_right), 0.0, (travel_right - travel_left) / (2.0 * kHalfTrack)});
    }
    last_left = left;
    last_right = right;

    scan->stamp = fromMicroseconds(utime);
    scan->size = 0;
    for (std::size_t i = kMargin; i < kBeams; ++i) {
      scan->push({.range = returnedRange((*numbers)[kFirstRange + i] * 1e-3),
                  .bearing = static_cast<float>(kFirstBearing + kStep * static_cast<double>(i))});
    }
    const double radians_per_tick = 2.0 * std::numbers::pi / kTicksPerTurn;
    log.add(utime, WheelSample{scan->stamp, pose}, utime,
            std::array{left * radians_per_tick, right * radians_per_tick});
    log.add(utime, *scan, utime);
    ++recording.wheels;
    recording.useScan(rows, utime);
  }
  reportDamage(file, in, recording);
  log.write(out, &recording);
  return recording;
}

}  // namespace slam
