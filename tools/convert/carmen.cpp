// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/messages.hpp"
#include "core/pose_history.hpp"
#include "tools/convert/formats.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNoReturns[] = {50.0, 81.83, 81.91};  // [m] what CARMEN's drivers write for "nothing seen"
constexpr std::size_t kWordsAfterRanges = 9;           // x y theta odom_x odom_y odom_theta stamp host loggerstamp

/// n beams to the step and the first bearing: 180 and 181, 360 and 361 beams mean 180 degrees in 1 or 0.5 degree steps.
std::pair<double, double> beamLayout(std::size_t n) {
  const double step = kPi / static_cast<double>(n % 2 == 1 ? n - 1 : n);
  return {-kPi / 2.0, step};
}

bool isNoReturn(double range) {
  if (!(range > 0.0) || range >= 81.0) return true;
  for (const double none : kNoReturns) {
    if (std::abs(range - none) < 0.005) return true;
  }
  return false;
}

struct Flaser {
  LaserScan scan;
  WheelSample wheels;
  std::int64_t utime;
};

/// @return what is wrong, or nullptr
const char* parseFlaser(const std::vector<std::string_view>& words, Flaser& out) {
  const auto n = words.size() > 1 ? toNumber(words[1]) : std::nullopt;
  if (!n || *n < 2 || *n > LaserScan::kCapacity || *n != std::floor(*n)) {
    return "the number of beams is not one";  // one beam alone has no bearing
  }
  const auto beams = static_cast<std::size_t>(*n);
  if (words.size() < 2 + beams + kWordsAfterRanges) return "fewer numbers than its count of beams asks for";
  const auto [first, step] = beamLayout(beams);
  out.scan.size = 0;
  out.scan.range_min = 0.02F;
  out.scan.range_max = 80.0F;
  for (std::size_t i = 0; i < beams; ++i) {
    // A range that is not a number (nan, inf, a cut word) is a beam without return, not a bad line.
    const double range = toNumber(words[2 + i]).value_or(0.0);
    out.scan.push({.range = isNoReturn(range) ? 0.0F : static_cast<float>(range),
                   .bearing = static_cast<float>(first + step * static_cast<double>(i))});
  }
  const std::size_t tail = 2 + beams;
  const auto x = toNumber(words[tail + 3]), y = toNumber(words[tail + 4]), theta = toNumber(words[tail + 5]);
  const auto utime = toMicroseconds(words[tail + 6]);
  if (!x || !y || !theta) return "its odometry is not three numbers";
  if (!utime || *utime <= 0) return "its stamp is not a time";
  out.utime = *utime;
  out.scan.stamp = out.wheels.stamp = fromMicroseconds(*utime);
  out.wheels.T_wheels_base = {*x, *y, *theta};
  return nullptr;
}

}  // namespace

ConvertReport convertCarmen(const std::filesystem::path& in, const std::filesystem::path& out) {
  TextFile file(in);
  ConvertReport report;
  LogOutput log;
  auto flaser = std::make_unique<Flaser>();
  std::int64_t arrival = 0;  // the log's order is the truth; stamps may go back
  for (std::string line; file.next(line);) {
    const auto words = splitWords(line);
    const std::string where = in.filename().string() + ":" + std::to_string(file.lineNumber());
    if (words.empty()) continue;
    if (words[0] == "FLASER") {
      if (const char* wrong = parseFlaser(words, *flaser)) {
        report.reject(where, wrong);
        continue;
      }
      arrival = std::max(arrival, flaser->utime);
      log.add(arrival, flaser->wheels, flaser->utime);
      log.add(arrival, flaser->scan, flaser->utime);
      ++report.wheels;
      ++report.scans;
    } else if (words[0] == "ODOM") {
      const auto x = words.size() > 7 ? toNumber(words[1]) : std::nullopt;
      const auto y = x ? toNumber(words[2]) : std::nullopt, theta = y ? toNumber(words[3]) : std::nullopt;
      const auto utime = theta ? toMicroseconds(words[7]) : std::nullopt;
      if (!utime || *utime <= 0) {
        report.reject(where, "not an ODOM line with six numbers and a stamp");
        continue;
      }
      arrival = std::max(arrival, *utime);
      log.add(arrival, WheelSample{fromMicroseconds(*utime), {*x, *y, *theta}}, *utime);
      ++report.wheels;
    }
  }
  reportDamage(file, in, report);
  if (report.scans == 0) {
    throw std::runtime_error(in.string() + ": no usable FLASER line; is it a CARMEN log?" +
                             (report.rejected ? " First refused: " + report.first_rejection : ""));
  }
  log.write(out);
  return report;
}

ConvertReport convertToCarmen(const std::filesystem::path& in, const std::filesystem::path& out) {
  EventLogReader log(in);
  std::FILE* file = std::fopen(out.c_str(), "w");
  if (file == nullptr) throw std::runtime_error(out.string() + ": cannot write: " + std::strerror(errno));
  std::fputs("# CARMEN log written by slam-convert; ranges resampled to equal steps, 81.83: no return\n", file);

  ConvertReport report;
  PoseHistory wheels(4096);
  std::int64_t first = -1;
  for (LogEvent event; log.next(event);) {
    if (first < 0) first = event.utime;
    if (event.channel == channel::kWheels) {
      const auto message = decodeChecked<wheels_t>(event.data);
      const auto sample = message ? fromMessage(*message) : std::nullopt;
      if (!sample) {
        report.reject(in.filename().string(), "a SLAM_WHEELS message that does not decode");
        continue;
      }
      wheels.push(sample->stamp, sample->T_wheels_base);
      ++report.wheels;
    } else if (event.channel == channel::kScan) {
      const auto message = decodeChecked<scan_t>(event.data);
      const auto scan = message ? fromMessage(*message) : std::nullopt;
      if (!scan || scan->size == 0) {
        report.reject(in.filename().string(), "a SLAM_SCAN message that does not decode");
        continue;
      }
      // Half turn or full turn, whichever the beams need; in steps near the scan's own.
      float widest = 0.0F;
      for (const Beam& beam : scan->beams()) widest = std::max(widest, std::abs(beam.bearing));
      const bool half = widest <= kPi / 2.0 + 1e-3;
      const int n = half ? (scan->size > 270 ? 361 : (scan->size == 180 ? 180 : 181)) : 720;
      const double span = half ? kPi : 2.0 * kPi, start = -span / 2.0;
      const double step = span / (half && n % 2 == 1 ? n - 1 : n);
      std::vector<double> ranges(static_cast<std::size_t>(n), 81.83);
      for (const Beam& beam : scan->beams()) {
        const auto i = std::lround((static_cast<double>(beam.bearing) - start) / step);
        if (!scan->isReturn(beam) || i < 0 || i >= n) continue;
        double& range = ranges[static_cast<std::size_t>(i)];
        range = std::min(range, static_cast<double>(beam.range));
      }
      const Pose2 odom = wheels.at(scan->stamp, std::chrono::seconds(1)).value_or(Pose2{});
      std::fprintf(file, "FLASER %d", n);
      for (const double range : ranges) std::fprintf(file, " %.3f", range);
      for (int i = 0; i < 2; ++i) std::fprintf(file, " %.6f %.6f %.6f", odom.x, odom.y, odom.theta);
      std::fprintf(file, " %.6f slamd %.6f\n", static_cast<double>(message->utime) * 1e-6,
                   static_cast<double>(event.utime - first) * 1e-6);
      ++report.scans;
    }
  }
  const bool failed = std::ferror(file) != 0;
  if (std::fclose(file) != 0 || failed) throw std::runtime_error(out.string() + ": cannot write all of it");
  if (report.scans == 0) throw std::runtime_error(in.string() + ": no SLAM_SCAN in it");
  return report;
}

}  // namespace slam
