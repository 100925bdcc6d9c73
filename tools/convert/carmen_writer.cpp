// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "bus/channels.hpp"
#include "bus/received.hpp"
#include "core/pose_history.hpp"
#include "tools/convert/carmen.hpp"
#include "tools/convert/formats.hpp"
#include "tools/convert/log_output.hpp"

namespace slam {
namespace {

constexpr double kNoReturn = 81.83;  // [m] as CARMEN's drivers write it
constexpr double kOff = 0.05;        // [1] of a step, [rad]: bearings that differ by less are one

double bearingOf(const Beam& beam) { return wrapAngle(static_cast<double>(beam.bearing)); }

/// Bins of equal steps, as CARMEN has them, with the nearest return in each.
struct Bins {
  double first, step;  // [rad]
  std::vector<double> ranges;
};

/// @param turn the last bin is beside the first
/// @param exact each beam must have a bin of its own, at its bearing
/// @return nullopt: one has not
std::optional<Bins> binned(const LaserScan& scan, double first, double step, std::size_t count, bool turn, bool exact) {
  Bins bins{first, step, std::vector<double>(count, kNoReturn)};
  std::vector<char> taken(count, 0);
  for (const Beam& beam : scan.beams()) {
    const auto n = static_cast<long>(count);
    const double steps = (bearingOf(beam) - first) / step;
    long i = std::lround(steps);
    const bool off = std::abs(steps - static_cast<double>(i)) > kOff;
    if (turn) i = (i % n + n) % n;
    if (i < 0 || i >= n) continue;
    const auto at = static_cast<std::size_t>(i);
    if ((std::exchange(taken[at], 1) != 0 || off) && exact) return std::nullopt;
    if (scan.isReturn(beam)) bins.ranges[at] = std::min(bins.ranges[at], static_cast<double>(beam.range));
  }
  return bins;
}

/// A scan of half a turn or less, in the steps that FLASER knows.
Bins halfTurn(const LaserScan& scan) {
  const std::size_t n = scan.size > 270 ? 361 : (scan.size == 180 ? 180 : 181);
  const auto [first, step] = carmen::beamLayout(n);
  return *binned(scan, first, step, n, false, false);
}

/// Any other scan, in its own steps, or in a quarter of them where they are uneven.
Bins wideScan(const LaserScan& scan) {
  const auto [lowest, highest] =
      std::minmax_element(scan.beams().begin(), scan.beams().end(),
                          [](const Beam& a, const Beam& b) { return bearingOf(a) < bearingOf(b); });
  const double first = bearingOf(*lowest), span = bearingOf(*highest) - first;
  const auto size = static_cast<std::size_t>(scan.size);
  const bool turn =
      span < kOff || (size > 8 && 2.0 * std::numbers::pi - span < 1.5 * span / static_cast<double>(size - 1));
  for (const std::size_t finer : {1, 4}) {
    const std::size_t steps = finer * (turn ? size : size - 1), count = turn ? steps : steps + 1;
    const bool last = finer > 1 || 4 * count > LaserScan::kCapacity;
    const double step = (turn ? 2.0 * std::numbers::pi : span) / static_cast<double>(steps);
    if (auto bins = binned(scan, first, step, count, turn, !last)) return *std::move(bins);
  }
  throw std::logic_error("the last bins take every beam");
}

void printLaser(std::FILE* file, const LaserScan& scan, const Pose2& odom) {
  double widest = 0.0;
  for (const Beam& beam : scan.beams()) widest = std::max(widest, std::abs(bearingOf(beam)));
  const bool half = scan.size == 1 || widest <= std::numbers::pi / 2.0 + 1e-3;
  const Bins bins = half ? halfTurn(scan) : wideScan(scan);
  if (half) {
    std::fprintf(file, "FLASER %zu", bins.ranges.size());
  } else {
    const double span = bins.step * static_cast<double>(bins.ranges.size() - 1);
    std::fprintf(file, "%s 0 %.9f %.9f %.12f %.3f 0.010 0 %zu", carmen::kRobotLaser.data(), bins.first, span, bins.step,
                 kNoReturn, bins.ranges.size());
  }
  for (const double range : bins.ranges) std::fprintf(file, " %.3f", range);
  if (!half) std::fputs(" 0", file);  // remissions
  for (int i = 0; i < 2; ++i) std::fprintf(file, " %.6f %.6f %.6f", odom.x, odom.y, odom.theta);
  if (!half) std::fputs(" 0 0 0 0 0", file);  // speeds, safety distances, turn axis
}

}  // namespace

Recording convertToCarmen(const std::filesystem::path& in, const std::filesystem::path& out) {
  EventLogReader log(in);
  std::FILE* file = std::fopen(out.c_str(), "w");
  if (file == nullptr) throw std::runtime_error(out.string() + ": cannot write: " + std::strerror(errno));
  std::fputs("# CARMEN log written by slam-convert; ranges resampled to equal steps, 81.83: no return\n", file);

  Recording report;
  PoseHistory wheels(4096);
  std::optional<WheelSample> newest;  // as it came: the history is by stamps, which may go back
  std::int64_t first = -1;
  for (LogEvent event; log.next(event);) {
    if (first < 0) first = event.utime;
    if (event.channel == channel::kWheels) {
      const Received<wheels_t> received(event.data);
      const auto& sample = received.sample;
      if (!sample) {
        report.reject(in.filename().string(), problemOf(received.refusal, event.channel).words());
        continue;
      }
      wheels.push(sample->stamp, sample->T_wheels_base);
      newest = sample;
      ++report.wheels;
    } else if (event.channel == channel::kScan) {
      const Received<scan_t> received(event.data);
      const auto& message = received.message;
      const auto& scan = received.sample;
      if (!scan || scan->size == 0) {
        report.reject(in.filename().string(),
                      scan ? "a SLAM_SCAN without beams" : problemOf(received.refusal, event.channel).words());
        continue;
      }
      const bool own = newest && newest->stamp == scan->stamp;
      printLaser(file, *scan,
                 own ? newest->T_wheels_base : wheels.at(scan->stamp, std::chrono::seconds(1)).value_or(Pose2{}));
      std::fprintf(file, " %.6f slamd %.6f\n", static_cast<double>(message->utime) * 1e-6,
                   static_cast<double>(event.utime - first) * 1e-6);
      ++report.scans;
    }
  }
  const bool failed = std::ferror(file) != 0;
  if (std::fclose(file) != 0 || failed) throw std::runtime_error(out.string() + ": cannot write all of it");
  if (report.scans == 0)
    throw std::runtime_error(in.string() + ": no SLAM_SCAN in it that can be used" +
                             (report.first_rejection.empty() ? "" : ": " + report.first_rejection));
  return report;
}

}  // namespace slam
