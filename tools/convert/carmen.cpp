// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/carmen.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <tuple>
#include <vector>

#include "tools/convert/formats.hpp"
#include "tools/convert/log_output.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNoReturns[] = {50.0, 81.83, 81.91};  // [m] what CARMEN's drivers write for "nothing seen"
constexpr const char* kNoCount = "the number of beams is not one";  // one beam alone has no bearing
constexpr const char* kTooShort = "fewer numbers than its count of beams asks for";

bool isNoReturn(double range, double range_max) {
  if (!(range > 0.0) || range >= range_max) return true;
  for (const double none : kNoReturns) {
    if (std::abs(range - none) < 0.005) return true;
  }
  return false;
}

struct LaserLine {
  LaserScan scan;
  WheelSample wheels;
  std::int64_t utime;
};

/// Where a laser line has what.
struct Layout {
  std::size_t beams = 0, ranges = 0, odometry = 0, stamp = 0;  // words
  double first = 0.0, step = 0.0;                              // [rad] bearings
  double range_max = 81.0;                                     // [m] this far and further is no return
};

std::optional<double> numberAt(const std::vector<std::string_view>& words, std::size_t i) {
  return i < words.size() ? toNumber(words[i]) : std::nullopt;
}

/// A count that is written at word i, nullopt: none that can be.
std::optional<std::size_t> countAt(const std::vector<std::string_view>& words, std::size_t i, std::size_t most) {
  const auto n = numberAt(words, i);
  if (!n || !(*n >= 0.0) || *n > static_cast<double>(most) || *n != std::floor(*n)) return std::nullopt;
  return static_cast<std::size_t>(*n);
}

/// FLASER n ranges x y theta odom_x odom_y odom_theta stamp host loggerstamp
const char* layOutFlaser(const std::vector<std::string_view>& words, Layout& out) {
  const auto n = countAt(words, 1, LaserScan::kCapacity);
  if (!n || *n < 2) return kNoCount;
  out.beams = *n;
  out.ranges = 2;
  std::tie(out.first, out.step) = carmen::beamLayout(*n);
  out.odometry = out.ranges + *n + 3;  // the pose before it may be corrected, or the laser's
  out.stamp = out.odometry + 3;
  const std::size_t usual = out.stamp + 3;  // with host and its stamp
  if (words.size() > usual && numberAt(words, out.stamp + 1)) return "it holds more numbers than its count says";
  return nullptr;
}

/// ROBOTLASER1 type first fov step max accuracy remission_mode n ranges [n_remissions remissions] laser_x laser_y
/// laser_theta x y theta tv rv forward_safety side_safety [turn_axis] stamp host loggerstamp; the first releases of
/// CARMEN wrote neither remissions nor turn axis.
const char* layOutRobotLaser(const std::vector<std::string_view>& words, Layout& out) {
  const auto n = countAt(words, 8, LaserScan::kCapacity);
  if (!n || *n < 2) return kNoCount;
  const auto first = numberAt(words, 2), step = numberAt(words, 4), range_max = numberAt(words, 5);
  if (!first || !step || !range_max || !(std::abs(*first) <= 2.0 * kPi) || !(*step > 0.0) || !(*range_max > 0.0) ||
      *step * static_cast<double>(*n - 1) > 2.0 * kPi + 1e-6) {
    return "its first bearing, step and greatest range cannot be a laser's";
  }
  constexpr std::size_t kBehindRanges = 13;  // without remissions and turn axis
  std::size_t poses = 9 + *n;
  if (words.size() < poses + kBehindRanges) return kTooShort;
  const auto remissions = countAt(words, poses, LaserScan::kCapacity);
  if (words.size() > poses + kBehindRanges + 1 && remissions) poses += 1 + *remissions;
  if (words.size() < poses + kBehindRanges) return kTooShort;
  out.beams = *n;
  out.ranges = 9;
  out.first = *first;
  out.step = *step;
  out.range_max = std::min(81.0, *range_max);
  out.odometry = poses + 3;
  out.stamp = words.size() - 3;
  return nullptr;
}

/// @return what is wrong, or nullptr
const char* parseLaser(const std::vector<std::string_view>& words, LaserLine& out) {
  Layout at;
  const char* wrong = words[0] == carmen::kRobotLaser ? layOutRobotLaser(words, at) : layOutFlaser(words, at);
  if (wrong != nullptr) return wrong;
  if (words.size() < at.stamp + 3) return kTooShort;
  out.scan.size = 0;
  out.scan.range_min = 0.02F;
  out.scan.range_max = 80.0F;
  for (std::size_t i = 0; i < at.beams; ++i) {
    // A range that is not a number (nan, inf, a cut word) is a beam without return, not a bad line.
    const double range = toNumber(words[at.ranges + i]).value_or(0.0);
    const double bearing = wrapAngle(at.first + at.step * static_cast<double>(i));
    out.scan.push({.range = isNoReturn(range, at.range_max) ? 0.0F : static_cast<float>(range),
                   .bearing = static_cast<float>(bearing)});
  }
  const auto x = toNumber(words[at.odometry]), y = toNumber(words[at.odometry + 1]),
             theta = toNumber(words[at.odometry + 2]);
  const auto utime = toMicroseconds(words[at.stamp]);
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
  auto laser = std::make_unique<LaserLine>();
  std::int64_t arrival = 0;  // the log's order is the truth; stamps may go back
  for (std::string line; file.next(line);) {
    const auto words = splitWords(line);
    const std::string where = in.filename().string() + ":" + std::to_string(file.lineNumber());
    if (words.empty()) continue;
    if (words[0] == "FLASER" || words[0] == carmen::kRobotLaser) {
      if (const char* wrong = parseLaser(words, *laser)) {
        report.reject(where, wrong);
        continue;
      }
      arrival = std::max(arrival, laser->utime);
      log.add(arrival, laser->wheels, laser->utime);
      log.add(arrival, laser->scan, laser->utime);
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
    throw std::runtime_error(in.string() + ": no usable FLASER or ROBOTLASER1 line; is it a CARMEN log?" +
                             (report.rejected ? " First refused: " + report.first_rejection : ""));
  }
  log.write(out);
  return report;
}

}  // namespace slam
