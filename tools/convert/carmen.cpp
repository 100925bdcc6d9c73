// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/carmen.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "tools/convert/log_output.hpp"
#include "tools/convert/range_census.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSurelyNone[] = {50.0, 51.14, 81.83, 81.87, 81.91};  // [m] CARMEN's and SICK's "nothing seen"
constexpr double kNoneOf8Metres[] = {8.183, 8.187, 8.191};            // [m] SICK's, where it measures to 8 m
constexpr double kFarthest = 81.0;                                    // [m] this far and further is no return
constexpr double kTrusted = 50.0;         // [m] an LMS sees to 80 m; few of the returns beyond are real
constexpr std::int64_t kEpoch = 1000000;  // [us] added to clocks that begin at 0, which is no stamp
constexpr const char* kNoCount = "the number of beams is not one";  // one beam alone has no bearing
constexpr const char* kTooShort = "fewer numbers than its count of beams asks for";

struct LaserLine {
  std::vector<double> ranges;  // [m]; 0: not a number
  double first = 0.0, step = 0.0, range_max = kFarthest;
  Pose2 laser, robot;
  std::optional<std::int64_t> stamp, logger;  // [us] as written, nullopt: not a time
};

/// Where a laser line has what.
struct Layout {
  std::size_t beams = 0, ranges = 0, odometry = 0, stamp = 0;  // words
  double first = 0.0, step = 0.0;                              // [rad] bearings
  double range_max = kFarthest;                                // [m]
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
  out.range_max = std::min(kFarthest, *range_max);
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
  out.ranges.resize(at.beams);
  // A range that is not a number (nan, inf, a cut word) is a beam without return, not a bad line.
  for (std::size_t i = 0; i < at.beams; ++i) out.ranges[i] = toNumber(words[at.ranges + i]).value_or(0.0);
  out.first = at.first;
  out.step = at.step;
  out.range_max = at.range_max;
  const auto pose = [&](std::size_t word, Pose2& to) {
    const auto x = toNumber(words[word]), y = toNumber(words[word + 1]), theta = toNumber(words[word + 2]);
    if (x && y && theta) to = {*x, *y, *theta};
    return x && y && theta;
  };
  if (!pose(at.odometry, out.robot)) return "its odometry is not three numbers";
  constexpr double kNowhere = 1e9;  // [m] no laser sits there
  if (!pose(at.odometry - 3, out.laser)) out.laser = {kNowhere, kNowhere, 0.0};
  out.stamp = toMicroseconds(words[at.stamp]);
  out.logger = toMicroseconds(words[at.stamp + 2]);
  if (!out.stamp) return "its stamp is not a time";
  return nullptr;
}

struct OdomLine {
  Pose2 pose;
  std::int64_t stamp = 0;
  std::optional<std::int64_t> logger;
};

/// The time of a line by its own stamp and by the logger's [us].
struct LineStamp {
  std::int64_t stamp = 0;
  std::optional<std::int64_t> logger;
};

/// ODOM x y theta tv rv accel stamp host loggerstamp
const char* parseOdom(const std::vector<std::string_view>& words, OdomLine& out) {
  const auto x = numberAt(words, 1), y = numberAt(words, 2), theta = numberAt(words, 3);
  const auto stamp = words.size() > 7 ? toMicroseconds(words[7]) : std::nullopt;
  if (!x || !y || !theta || !stamp) return "not an ODOM line with six numbers and a stamp";
  out.pose = {*x, *y, *theta};
  out.stamp = *stamp;
  out.logger = words.size() > 9 ? toMicroseconds(words[9]) : std::nullopt;
  return nullptr;
}

bool isLaser(std::string_view word) { return word == "FLASER" || word == carmen::kRobotLaser; }

/// Stamps that are the same as before, or none.
struct StampCount {
  int lines = 0, useless = 0;
  std::int64_t last = 0;
  void add(std::optional<std::int64_t> stamp) {
    ++lines;
    if (!stamp || *stamp <= 0 || *stamp == last) ++useless;
    last = stamp.value_or(0);
  }
  bool serves() const { return 2 * useless <= lines; }
};

enum class Clock { kStamp, kLogger, kPeriod };

/// What a log says as a whole.
struct Survey {
  RangeCensus census;
  std::vector<Pose2> mounts;  // laser in the robot's frame
  std::map<std::string, double, std::less<>> parameters;
  StampCount stamps, loggers;
  std::optional<LineStamp> first;  // of the first line that has one
  int odom_lines = 0, odom_off = 0;
  double odom_farthest = 0.0;  // [m] off the odometry of the laser lines
  bool laser_odometry_moves = false, odom_moves = false;
  double range_max = kFarthest;  // [m] least of the lines
};

/// [m] of wheels that a line of another kind may have driven since
double reach(std::int64_t us) { return 0.1 + 2.0 * std::min(5.0, 1e-6 * static_cast<double>(std::abs(us))); }

Survey surveyed(const std::filesystem::path& in) {
  constexpr std::size_t kMostMounts = 200000;
  Survey survey;
  TextFile file(in);
  LaserLine laser;
  OdomLine odom, last_odom;
  std::optional<Pose2> last_robot;
  std::int64_t last_stamp = 0;
  const auto see = [&](std::int64_t stamp, std::optional<std::int64_t> logger) {
    if (!survey.first && stamp > 0) survey.first = {stamp, logger};
  };
  for (std::string line; file.next(line);) {
    const auto words = splitWords(line);
    if (words.empty()) continue;
    if (isLaser(words[0]) && parseLaser(words, laser) == nullptr) {
      see(*laser.stamp, laser.logger);
      for (std::size_t i = 0; i < laser.ranges.size(); ++i) {
        if (laser.ranges[i] < laser.range_max) survey.census.add(i, laser.ranges.size(), laser.ranges[i]);
      }
      survey.range_max = std::min(survey.range_max, laser.range_max);
      survey.stamps.add(laser.stamp);
      survey.loggers.add(laser.logger);
      if (survey.mounts.size() < kMostMounts) survey.mounts.push_back(between(laser.robot, laser.laser));
      if (last_robot && !(*last_robot == laser.robot)) survey.laser_odometry_moves = true;
      last_robot = laser.robot;
      last_stamp = *laser.stamp;
    } else if (words[0] == "ODOM" && parseOdom(words, odom) == nullptr) {
      see(odom.stamp, odom.logger);
      if (survey.odom_lines > 0 && !(odom.pose == last_odom.pose)) survey.odom_moves = true;
      last_odom = odom;
      ++survey.odom_lines;
      if (!last_robot) continue;
      const double off = std::hypot(odom.pose.x - last_robot->x, odom.pose.y - last_robot->y);
      if (off <= reach(odom.stamp - last_stamp)) continue;
      ++survey.odom_off;
      survey.odom_farthest = std::max(survey.odom_farthest, off);
    } else if (words[0] == "PARAM" && words.size() >= 3) {
      const auto value = toNumber(words[2]);
      if (value && (words[1].starts_with("robot_front") || words[1].starts_with("laser_front"))) {
        survey.parameters.emplace(words[1], *value);
      }
    }
  }
  return survey;
}

/// The mount that nearly all laser lines agree on.
std::optional<Pose2> commonMount(const std::vector<Pose2>& mounts) {
  constexpr double kFarthestMount = 2.0, kSame = 0.011, kSameAngle = 0.01;  // [m, m, rad]; some logs have two decimals
  if (mounts.empty()) return std::nullopt;
  const double zero = mounts.front().theta;
  const auto median = [&](auto value) {
    std::vector<double> values;
    for (const Pose2& mount : mounts) values.push_back(value(mount));
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  const Pose2 mount{median([](const Pose2& m) { return m.x; }), median([](const Pose2& m) { return m.y; }),
                    wrapAngle(zero + median([&](const Pose2& m) { return wrapAngle(m.theta - zero); }))};
  const auto same = std::count_if(mounts.begin(), mounts.end(), [&](const Pose2& m) {
    return std::abs(m.x - mount.x) < kSame && std::abs(m.y - mount.y) < kSame &&
           std::abs(wrapAngle(m.theta - mount.theta)) < kSameAngle;
  });
  const bool near = std::abs(mount.x) <= kFarthestMount && std::abs(mount.y) <= kFarthestMount;
  if (!near || 10 * static_cast<std::size_t>(same) < 9 * mounts.size()) return std::nullopt;
  return mount;
}

void findMount(const Survey& survey, Recording& recording) {
  constexpr double kCentred = 0.0015, kAligned = 0.002;  // [m, rad]
  const auto parameter = [&](const char* name) {
    const auto at = survey.parameters.find(name);
    return at == survey.parameters.end() ? 0.0 : at->second;
  };
  const Pose2 told{parameter("robot_frontlaser_offset"), parameter("robot_frontlaser_side_offset"),
                   parameter("robot_frontlaser_angular_offset")};
  const auto common = commonMount(survey.mounts);
  Pose2 mount = common.value_or(Pose2{});
  if (common) recording.robot.mount_source = "the laser's and the robot's pose in each laser line";
  if (std::hypot(mount.x, mount.y) < kCentred && std::abs(mount.theta) < kAligned) {
    mount = told;
    if (survey.parameters.contains("robot_frontlaser_offset")) {
      recording.robot.mount_source = "PARAM robot_frontlaser_offset";
    }
  }
  if (!common) {
    recording.notes.emplace_back(
        "the laser's poses do not keep a place on the robot: they are corrected ones and were not used");
  }
  recording.robot.lidar_x = mount.x;
  recording.robot.lidar_y = mount.y;
  recording.robot.lidar_yaw = mount.theta;
}

/// What is a return, and what a code.
class ReturnTest {
 public:
  explicit ReturnTest(const Survey& survey) : codes_(survey.census.codes()) {
    const double farthest = survey.census.largest();
    if (std::any_of(std::begin(kNoneOf8Metres), std::end(kNoneOf8Metres),
                    [&](double code) { return isCode(farthest, code); })) {
      codes_.insert(codes_.end(), std::begin(kNoneOf8Metres), std::end(kNoneOf8Metres));
      std::sort(codes_.begin(), codes_.end());
      codes_.erase(std::unique(codes_.begin(), codes_.end(), isCode), codes_.end());
    }
    for (const double code : codes_) lowest_ = std::min(lowest_, code);
  }
  bool operator()(double range, double range_max) const {
    if (!(range > 0.0) || range >= range_max) return false;
    for (const double none : kSurelyNone) {
      if (std::abs(range - none) < 0.005) return false;
    }
    return std::none_of(codes_.begin(), codes_.end(), [&](double code) { return isCode(range, code); });
  }
  /// [m] below which all is a return
  double lowestCode() const { return lowest_; }
  std::string found() const {
    std::string text;
    for (const double code : codes_) {
      char word[32];
      std::snprintf(word, sizeof(word), "%s%.3f", text.empty() ? "" : ", ", code);
      text += word;
    }
    return text;
  }

 private:
  std::vector<double> codes_;
  double lowest_ = kTrusted + RangeCensus::kStep;
};

/// The time of each line by the clock that serves.
class LineTimes {
 public:
  /// @param first of the log's lines with a stamp
  LineTimes(Clock clock, std::int64_t period, std::optional<LineStamp> first)
      : clock_(clock), period_(period), before_(first) {}

  std::optional<std::int64_t> ofLaser(std::int64_t stamp, std::optional<std::int64_t> logger) {
    if (clock_ == Clock::kPeriod) return last_ = last_ == 0 ? kEpoch : last_ + period_;
    return of(stamp, logger);
  }
  std::optional<std::int64_t> ofOdom(std::int64_t stamp, std::optional<std::int64_t> logger) {
    return clock_ == Clock::kPeriod ? std::nullopt : of(stamp, logger);
  }

 private:
  std::optional<std::int64_t> of(std::int64_t stamp, std::optional<std::int64_t> logger) {
    std::optional<std::int64_t> utime;
    if (clock_ == Clock::kLogger) {
      if (!logger || *logger < 0) return std::nullopt;
      if (last_ == 0) shift_ = *logger < kEpoch ? kEpoch : 0;
      utime = *logger + shift_;
    } else if (stamp > 0) {
      utime = stamp;
    } else if (before_) {  // a stamp of 0 is none: the logger's step from the line before, or from the first
      const bool known =
          tells(logger) && tells(before_->logger) && std::abs(*logger - *before_->logger) < kFarthestStep;
      utime = std::max<std::int64_t>(1, before_->stamp + (known ? *logger - *before_->logger : 0));
    }
    if (!utime || *utime <= 0) return std::nullopt;
    last_ = *utime;
    before_ = {*utime, logger};
    return utime;
  }

  /// A logger's time of 0 is none, either.
  static bool tells(const std::optional<std::int64_t>& logger) { return logger && *logger > 0; }

  Clock clock_;
  static constexpr std::int64_t kFarthestStep = 3600000000;  // [us] the logger's clock is another by then
  std::int64_t period_, last_ = 0, shift_ = 0;
  std::optional<LineStamp> before_;  // of the newest line
};

Clock clockOf(const Survey& survey, const CarmenOptions& options, Recording& recording,
              const std::filesystem::path& in) {
  if (survey.stamps.serves()) return Clock::kStamp;
  const std::string what = "most of its stamps are 0 or equal";
  if (survey.loggers.serves()) {
    recording.notes.push_back(what + ": the logger's stamps, the last word of each line, were used");
    return Clock::kLogger;
  }
  if (!options.period) {
    throw std::runtime_error(in.string() + ": " + what +
                             ", and the logger's, too; nothing was written. Give the time "
                             "from scan to scan with --period SECONDS");
  }
  recording.notes.push_back(what + ", and the logger's, too: --period was used, and ODOM lines were not");
  return Clock::kPeriod;
}

}  // namespace

Recording convertCarmen(const std::filesystem::path& in, const std::filesystem::path& out,
                        const CarmenOptions& options) {
  const Survey survey = surveyed(in);
  TextFile file(in);
  Recording recording;
  recording.format = "CARMEN log";
  const ReturnTest isReturn(survey);
  const Clock clock = survey.stamps.lines > 0 ? clockOf(survey, options, recording, in) : Clock::kStamp;
  LineTimes times(clock, std::llround(1e6 * options.period.value_or(0.0)), survey.first);
  const bool corrected = survey.odom_off >= 2 && 10 * survey.odom_off > survey.odom_lines;
  const bool odom_only = corrected && !survey.laser_odometry_moves && survey.odom_moves;
  const bool use_odom = (!corrected || odom_only) && clock != Clock::kPeriod;
  LogOutput log;
  LaserLine laser;
  OdomLine odom;
  auto scan = std::make_unique<LaserScan>();
  scan->range_min = 0.02F;
  scan->range_max = 80.0F;
  std::map<std::string, int, std::less<>> others;
  std::int64_t arrival = 0;  // the log's order is the truth; stamps may go back
  for (std::string line; file.next(line);) {
    const auto words = splitWords(line);
    const std::string where = in.filename().string() + ":" + std::to_string(file.lineNumber());
    if (words.empty()) continue;
    if (isLaser(words[0])) {
      SensorRows& rows = recording.sensor(std::string(words[0]));
      const char* wrong = parseLaser(words, laser);
      const auto utime = wrong == nullptr ? times.ofLaser(*laser.stamp, laser.logger) : std::nullopt;
      if (!utime) {
        recording.reject(rows, where, wrong != nullptr ? wrong : "its stamp is not a time");
        continue;
      }
      scan->size = 0;
      scan->stamp = fromMicroseconds(*utime);
      for (std::size_t i = 0; i < laser.ranges.size(); ++i) {
        const double bearing = wrapAngle(laser.first + laser.step * static_cast<double>(i));
        scan->push({.range = isReturn(laser.ranges[i], laser.range_max) ? static_cast<float>(laser.ranges[i]) : 0.0F,
                    .bearing = static_cast<float>(bearing)});
      }
      arrival = std::max(arrival, *utime);
      if (!odom_only) {
        log.add(arrival, WheelSample{scan->stamp, laser.robot}, *utime);
        recording.useWheels(recording.sensor("odometry of " + std::string(words[0]) + " lines"), *utime);
      }
      log.add(arrival, *scan, *utime);
      recording.useScan(rows, *utime);
    } else if (words[0] == "ODOM") {
      SensorRows& rows = recording.sensor("ODOM");
      const char* wrong = parseOdom(words, odom);
      const auto utime = wrong == nullptr && use_odom ? times.ofOdom(odom.stamp, odom.logger) : std::nullopt;
      if (wrong != nullptr || (use_odom && !utime)) {
        recording.reject(rows, where, wrong != nullptr ? wrong : "its stamp is not a time");
        continue;
      }
      if (!use_odom) continue;
      arrival = std::max(arrival, *utime);
      log.add(arrival, WheelSample{fromMicroseconds(*utime), odom.pose}, *utime);
      recording.useWheels(rows, *utime);
    } else if (words[0].front() != '#' && words[0] != "PARAM") {
      constexpr std::size_t kMostKinds = 32, kLongest = 24;
      const std::string_view kind = words[0].substr(0, kLongest);
      const auto at = others.find(kind);
      if (at != others.end()) ++at->second;
      if (at == others.end() && others.size() < kMostKinds) others.emplace(kind, 1);
    }
  }
  reportDamage(file, in, recording);
  if (recording.scans == 0) {
    throw std::runtime_error(in.string() + ": no usable FLASER or ROBOTLASER1 line; is it a CARMEN log?" +
                             (recording.rejected ? " First refused: " + recording.first_rejection : ""));
  }
  for (const auto& [kind, count] : others) {
    recording.unused.push_back(std::to_string(count) + " lines " + kind + ": of a kind that is not read");
  }
  if (corrected && !odom_only) {
    char words[200];
    std::snprintf(words, sizeof(words),
                  "%d ODOM lines: %d lie up to %.1f m off the odometry of the laser lines, so they are corrected poses",
                  survey.odom_lines, survey.odom_off, survey.odom_farthest);
    recording.unused.emplace_back(words);
    recording.notes.emplace_back(
        "the ODOM lines hold corrected poses, which are no wheels: the laser lines' odometry was used alone");
  }
  if (odom_only) {
    recording.notes.emplace_back("the odometry of the laser lines does not move: the ODOM lines were used alone");
  }
  findMount(survey, recording);
  if (const std::string found = isReturn.found(); !found.empty()) {
    recording.notes.push_back("ranges of " + found + " m count as no return");
  }
  const double lowest = std::min({isReturn.lowestCode() - RangeCensus::kStep, survey.range_max, kTrusted});
  recording.robot.range_min = 0.05;
  recording.robot.range_max = std::floor(lowest * 100.0 + 1e-6) * 0.01;
  log.write(out, &recording);
  return recording;
}

}  // namespace slam
