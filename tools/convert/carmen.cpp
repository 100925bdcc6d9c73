// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/carmen.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "tools/convert/assembler.hpp"
#include "tools/convert/formats.hpp"
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

/// A line of a laser, or of the odometry alone.
struct Line {
  Pose2 robot, laser;
  std::optional<std::int64_t> stamp, logger;  // [us] as written, nullopt: not a time
  std::vector<double> ranges;                 // [m]; 0: not a number, or out of range
  double first = 0.0, step = 0.0;             // [rad] bearings
  double range_max = kFarthest;               // [m]
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

bool readPose(const std::vector<std::string_view>& words, std::size_t at, Pose2& pose) {
  const auto x = numberAt(words, at), y = numberAt(words, at + 1), theta = numberAt(words, at + 2);
  if (x && y && theta) pose = {*x, *y, *theta};
  return x && y && theta;
}

void readStamps(const std::vector<std::string_view>& words, std::size_t at, Line& out) {
  const auto time = [&](std::size_t i) { return i < words.size() ? toMicroseconds(words[i]) : std::nullopt; };
  out.stamp = time(at);
  out.logger = time(at + 2);
}

/// @return what is wrong, or nullptr
const char* parseLaser(const std::vector<std::string_view>& words, Line& out) {
  Layout at;
  const char* wrong = words[0] == carmen::kRobotLaser ? layOutRobotLaser(words, at) : layOutFlaser(words, at);
  if (wrong != nullptr) return wrong;
  if (words.size() < at.stamp + 3) return kTooShort;
  out.first = at.first;
  out.step = at.step;
  out.range_max = at.range_max;
  out.ranges.resize(at.beams);
  for (std::size_t i = 0; i < at.beams; ++i) {
    // A range that is not a number (nan, inf, a cut word) is a beam without return, not a bad line.
    const double range = toNumber(words[at.ranges + i]).value_or(0.0);
    out.ranges[i] = range < at.range_max ? range : 0.0;
  }
  if (!readPose(words, at.odometry, out.robot)) return "its odometry is not three numbers";
  constexpr double kNowhere = 1e9;  // [m] no laser sits there
  if (!readPose(words, at.odometry - 3, out.laser)) out.laser = {kNowhere, kNowhere, 0.0};
  readStamps(words, at.stamp, out);
  return out.stamp ? nullptr : kNoTime;
}

/// ODOM x y theta tv rv accel stamp host loggerstamp
const char* parseOdom(const std::vector<std::string_view>& words, Line& out) {
  readStamps(words, 7, out);
  return readPose(words, 1, out.robot) && out.stamp ? nullptr : "not an ODOM line with six numbers and a stamp";
}

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

/// The mount that nearly all laser lines agree on.
std::optional<Pose2> commonMount(const std::vector<Pose2>& mounts) {
  constexpr double kFarthestMount = 2.0, kSame = 0.011, kSameAngle = 0.01;  // [m, m, rad]; some logs have two decimals
  if (mounts.empty()) return std::nullopt;
  const double zero = mounts.front().theta;
  const auto medianOf = [&](auto value) {
    std::vector<double> values;
    for (const Pose2& mount : mounts) values.push_back(value(mount));
    return median(std::move(values));
  };
  const Pose2 mount{medianOf([](const Pose2& m) { return m.x; }), medianOf([](const Pose2& m) { return m.y; }),
                    wrapAngle(zero + medianOf([&](const Pose2& m) { return wrapAngle(m.theta - zero); }))};
  const auto same = std::count_if(mounts.begin(), mounts.end(), [&](const Pose2& m) {
    return std::abs(m.x - mount.x) < kSame && std::abs(m.y - mount.y) < kSame &&
           std::abs(wrapAngle(m.theta - mount.theta)) < kSameAngle;
  });
  const bool near = std::abs(mount.x) <= kFarthestMount && std::abs(mount.y) <= kFarthestMount;
  if (!near || 10 * static_cast<std::size_t>(same) < 9 * mounts.size()) return std::nullopt;
  return mount;
}

/// The time of each line by the clock that serves.
class LineTimes {
 public:
  struct Stamp {
    std::int64_t own = 0;
    std::optional<std::int64_t> logger;
  };
  /// @param first of the log's lines with a stamp
  LineTimes(Clock clock, std::int64_t period, std::optional<Stamp> first)
      : clock_(clock), period_(period), before_(first) {}

  std::optional<std::int64_t> of(std::int64_t stamp, std::optional<std::int64_t> logger) {
    if (clock_ == Clock::kPeriod) return last_ = last_ == 0 ? kEpoch : last_ + period_;
    std::optional<std::int64_t> utime;
    if (clock_ == Clock::kLogger) {
      if (!logger || *logger < 0) return std::nullopt;
      if (last_ == 0) shift_ = *logger < kEpoch ? kEpoch : 0;
      utime = *logger + shift_;
    } else if (stamp > 0) {
      utime = stamp;
    } else if (before_) {  // a stamp of 0 is none: the logger's step from the line before, or from the first
      const bool known =
          isSet(logger) && isSet(before_->logger) && std::abs(*logger - *before_->logger) < kFarthestStep;
      utime = std::max<std::int64_t>(1, before_->own + (known ? *logger - *before_->logger : 0));
    }
    if (!utime || *utime <= 0) return std::nullopt;
    last_ = *utime;
    before_ = {*utime, logger};
    return utime;
  }

 private:
  /// A logger's time of 0 is none, either.
  static bool isSet(const std::optional<std::int64_t>& logger) { return logger && *logger > 0; }

  Clock clock_;
  static constexpr std::int64_t kFarthestStep = 3600000000;  // [us] the logger's clock is another by then
  std::int64_t period_, last_ = 0, shift_ = 0;
  std::optional<Stamp> before_;  // of the newest line
};

/// Whether the ways of ODOM lines and laser lines agree: in corrected logs only one of them is as it was measured.
class OdomLines {
 public:
  /// @param robot in a laser line, stamp [us] of it
  void addLaser(const Pose2& robot, std::int64_t stamp) {
    if (last_laser_ && !(last_laser_->first == robot)) laser_moves_ = true;
    last_laser_ = {robot, stamp};
  }
  void addOdom(const Pose2& robot, std::int64_t stamp) {
    if (lines_++ > 0 && !(robot == last_odom_)) odom_moves_ = true;
    last_odom_ = robot;
    if (!last_laser_) return;
    const auto& [robot_then, then] = *last_laser_;
    const double off = std::hypot(robot.x - robot_then.x, robot.y - robot_then.y);
    const double seconds = std::min(5.0, 1e-6 * static_cast<double>(std::abs(stamp - then)));
    if (off <= 0.1 + 2.0 * seconds) return;  // [m] what the wheels may have driven since
    ++off_;
    farthest_ = std::max(farthest_, off);
  }

  bool corrected() const { return off_ >= 2 && 10 * off_ > lines_; }
  bool areAllThatMoves() const { return corrected() && !laser_moves_ && odom_moves_; }
  int lines() const { return lines_; }
  int off() const { return off_; }               ///< of them, the robot elsewhere than in the laser lines
  double farthest() const { return farthest_; }  ///< [m] off the odometry of the laser lines

 private:
  std::optional<std::pair<Pose2, std::int64_t>> last_laser_;  // the robot's pose, and [us]
  Pose2 last_odom_;
  int lines_ = 0, off_ = 0;
  double farthest_ = 0.0;  // [m]
  bool laser_moves_ = false, odom_moves_ = false;
};

class Carmen : public Reader {
 public:
  Carmen(const std::filesystem::path& in, const CarmenOptions& options)
      : Reader(in, 0.02F, 80.0F), period_(options.period) {}

  void read(Assembler& to) override {
    LineTimes times(clock_, std::llround(1e6 * period_.value_or(0.0)), first_);
    Line line;
    std::int64_t arrival = 0;  // the log's order is the truth; stamps may go back
    forEachLine(in_, to, [&](const auto& words, Origin at) {
      const bool laser = words[0] == "FLASER" || words[0] == carmen::kRobotLaser;
      if (!laser && words[0] != "ODOM") return readOther(words, to);
      at.sensor = words[0];
      if (!to.surveying()) to.rows(at);
      const char* wrong = laser ? parseLaser(words, line) : parseOdom(words, line);
      if (wrong != nullptr) return to.refuse(at, wrong);
      if (to.surveying() && !laser) return surveyOdom(line);
      if (to.surveying()) surveyLaser(line);
      if (!laser && !use_odom_) return;
      const auto utime = to.surveying() ? line.stamp : times.of(*line.stamp, line.logger);
      if (!utime) return to.refuse(at, kNoTime);
      at.stamp = *utime;
      at.received = arrival = std::max(arrival, *utime);
      if (!laser) return to.wheels(at, line.robot);
      if (!odom_only_) to.wheels(at.of("odometry of " + at.sensor + " lines"), line.robot);
      scan_->size = 0;
      for (std::size_t i = 0; i < line.ranges.size(); ++i) {
        const double bearing = wrapAngle(line.first + line.step * static_cast<double>(i));
        scan_->push({.range = isReturn(line.ranges[i]) ? static_cast<float>(line.ranges[i]) : 0.0F,
                     .bearing = static_cast<float>(bearing)});
      }
      to.scan(at, *scan_, {.written = line.ranges});
    });
  }

  void decide(Assembler& to) override {
    const auto isFarthest = [&](double code) { return isCode(to.census.largest(), code); };
    if (std::any_of(std::begin(kNoneOf8Metres), std::end(kNoneOf8Metres), isFarthest)) {
      to.codes.insert(to.codes.end(), std::begin(kNoneOf8Metres), std::end(kNoneOf8Metres));
      std::sort(to.codes.begin(), to.codes.end());
      to.codes.erase(std::unique(to.codes.begin(), to.codes.end(), isCode), to.codes.end());
    }
    if (stamps_.lines > 0 && !stamps_.serves()) chooseClock(to.recording);
    corrected_ = odom_.corrected();
    odom_only_ = odom_.areAllThatMoves();
    use_odom_ = (!corrected_ || odom_only_) && clock_ != Clock::kPeriod;
  }

  void finish(Assembler& to) override {
    Recording& recording = to.recording;
    recording.format = "CARMEN log";
    if (recording.scans == 0) {
      throw std::runtime_error(in_.string() + ": no usable FLASER or ROBOTLASER1 line; is it a CARMEN log?" +
                               (recording.rejected ? " First refused: " + recording.first_rejection : ""));
    }
    for (const auto& [kind, count] : to.passedOver()) {
      recording.unused.push_back(std::to_string(count) + " lines " + kind + ": of a kind that is not read");
    }
    if (corrected_ && !odom_only_) {
      char words[200];
      std::snprintf(
          words, sizeof(words),
          "%d ODOM lines: %d lie up to %.1f m off the odometry of the laser lines, so they are corrected poses",
          odom_.lines(), odom_.off(), odom_.farthest());
      recording.unused.emplace_back(words);
      recording.notes.emplace_back(
          "the ODOM lines hold corrected poses, which are no wheels: the laser lines' odometry was used alone");
    }
    if (odom_only_) {
      recording.notes.emplace_back("the odometry of the laser lines does not move: the ODOM lines were used alone");
    }
    findMount(recording);
    std::string found;
    double lowest = std::min(kTrusted, range_max_);  // [m] below which all is a return
    for (const double code : to.codes) {
      char word[32];
      std::snprintf(word, sizeof(word), "%s%.3f", found.empty() ? "" : ", ", code);
      found += word;
      lowest = std::min(lowest, code - RangeCensus::kStep);
    }
    if (!found.empty()) recording.notes.push_back("ranges of " + found + " m count as no return");
    recording.robot.range_min = 0.05;
    recording.robot.range_max = std::floor(lowest * 100.0 + 1e-6) * 0.01;
  }

 private:
  static bool isReturn(double range) {
    return range > 0.0 && std::none_of(std::begin(kSurelyNone), std::end(kSurelyNone),
                                       [&](double none) { return std::abs(range - none) < 0.005; });
  }

  void surveyStamp(const Line& line) {
    if (!first_ && *line.stamp > 0) first_ = {*line.stamp, line.logger};
  }
  void surveyLaser(const Line& line) {
    constexpr std::size_t kMostMounts = 200000;
    surveyStamp(line);
    range_max_ = std::min(range_max_, line.range_max);
    stamps_.add(line.stamp);
    loggers_.add(line.logger);
    if (mounts_.size() < kMostMounts) mounts_.push_back(between(line.robot, line.laser));
    odom_.addLaser(line.robot, *line.stamp);
  }
  void surveyOdom(const Line& line) {
    surveyStamp(line);
    odom_.addOdom(line.robot, *line.stamp);
  }
  void readOther(const std::vector<std::string_view>& words, Assembler& to) {
    constexpr std::size_t kMostKinds = 32, kLongest = 24;
    if (words[0] != "PARAM" && words[0].front() != '#') to.passOver(words[0].substr(0, kLongest), kMostKinds);
    const auto value = words[0] == "PARAM" ? numberAt(words, 2) : std::nullopt;
    if (value && (words[1].starts_with("robot_front") || words[1].starts_with("laser_front"))) {
      parameters_.emplace(words[1], *value);
    }
  }

  void chooseClock(Recording& recording) {
    const std::string what = "most of its stamps are 0 or equal";
    clock_ = loggers_.serves() ? Clock::kLogger : Clock::kPeriod;
    if (clock_ == Clock::kLogger) {
      recording.notes.push_back(what + ": the logger's stamps, the last word of each line, were used");
      return;
    }
    if (!period_) {
      throw std::runtime_error(in_.string() + ": " + what +
                               ", and the logger's, too; nothing was written. Give the time "
                               "from scan to scan with --period SECONDS");
    }
    recording.notes.push_back(what + ", and the logger's, too: --period was used, and ODOM lines were not");
  }

  void findMount(Recording& recording) const {
    constexpr double kCentred = 0.0015, kAligned = 0.002;  // [m, rad]
    const auto parameter = [&](const char* name) {
      const auto at = parameters_.find(name);
      return at == parameters_.end() ? 0.0 : at->second;
    };
    const Pose2 told{parameter("robot_frontlaser_offset"), parameter("robot_frontlaser_side_offset"),
                     parameter("robot_frontlaser_angular_offset")};
    const auto common = commonMount(mounts_);
    Pose2 mount = common.value_or(Pose2{});
    if (common) recording.robot.mount_source = "the laser's and the robot's pose in each laser line";
    if (std::hypot(mount.x, mount.y) < kCentred && std::abs(mount.theta) < kAligned) {
      mount = told;
      if (parameters_.contains("robot_frontlaser_offset")) {
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

  std::optional<double> period_;  // [s]
  // Of the survey:
  std::vector<Pose2> mounts_;  // laser in the robot's frame
  std::map<std::string, double, std::less<>> parameters_;
  StampCount stamps_, loggers_;
  std::optional<LineTimes::Stamp> first_;  // of the first line that has one
  OdomLines odom_;
  double range_max_ = kFarthest;  // [m] least of the lines
  // What it decides:
  Clock clock_ = Clock::kStamp;
  bool corrected_ = false, odom_only_ = false, use_odom_ = true;
};

}  // namespace

Recording convertCarmen(const std::filesystem::path& in, const std::filesystem::path& out,
                        const CarmenOptions& options) {
  return assemble(Carmen(in, options), out);
}

}  // namespace slam
