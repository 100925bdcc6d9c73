// SPDX-License-Identifier: BSD-3-Clause
#include "slam/motion_probe.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "matching/deskew.hpp"
#include "matching/normals.hpp"
#include "matching/plicp.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kHistory = 1024;                // samples of wheels and of the gyro
constexpr double kEnoughTravel = 0.10;                // [m] that ends a pair ...
constexpr double kEnoughTurn = 0.12;                  // [rad]
constexpr Duration kLongest = 1s, kOverdue = 2s;      // ... as does the time; later it is given up
constexpr Duration kPeriod = 1s, kLongPeriod = 30s;   // between pairs
constexpr Duration kBeyond = 60ms;                    // a history counts as reaching a scan so much later
constexpr Duration kGyroGap = 200ms;                  // a gyro that was silent for longer has lost count
constexpr Duration kClockStep = 1s;                   // back by more: the stream begins anew
constexpr double kSmallTurn = 0.03;                   // [rad] needs no guess
constexpr double kOverlap = 0.75;                     // [1] of a pair that is believed
constexpr double kCoarse = 1.5;                       // [1] between so few beams a pair of scans can hide a travel
constexpr double kTurnIn = 0.3;                       // [1] share of a blind direction that is a turn
constexpr double kStill = 0.002, kStillTurn = 0.005;  // [m], [rad] between two scans, of a robot at rest
constexpr int kLeastReturns = 10;

/// Two scans lie within a second: the reference needs neither room nor fine cells.
ReferenceConfig smallReference(ReferenceConfig config) {
  config.extent = 51.2;
  config.fine_cell = 0.10;
  config.fine_radius = 0.30;
  config.coarse_cell = 0.40;
  config.max_surfels = LaserScan::kCapacity;
  return config;
}

/// Where the history's pose is at `stamp`; a clock that was set back begins it anew.
void record(PoseHistory& history, Timestamp stamp, const Pose2& pose) {
  if (!history.empty() && history.newest().stamp - stamp > kClockStep) history.clear();
  history.push(stamp, pose);
}

}  // namespace

MotionProbe::MotionProbe(const LocalizerConfig& config)
    : lidar_(config.lidar),
      wheel_offset_(fromSeconds(config.wheel_time_offset)),
      imu_offset_(fromSeconds(config.imu_time_offset)),
      normals_(config.normals),
      match_(config.match),
      wheels_(kHistory),
      gyro_(kHistory),
      reference_(smallReference(config.reference)) {
  normals_.range_sigma = match_.range_sigma = lidar_.range_sigma;
  first_points_.reserve(LaserScan::kCapacity);
  second_points_.reserve(LaserScan::kCapacity);
}

void MotionProbe::add(const WheelSample& sample) {
  wheels_turn_known_ = sample.turn_rate_known;
  record(wheels_, sample.stamp + wheel_offset_, sample.T_wheels_base);
}

void MotionProbe::add(const ImuSample& recorded) {
  ImuSample sample = recorded;
  sample.stamp += imu_offset_;
  Pose2 heading;
  if (!gyro_.empty()) {
    const Duration interval = sample.stamp - gyro_.newest().stamp;
    if (interval > kGyroGap) {
      gyro_.clear();
    } else {
      heading.theta = wrapAngle(gyro_.newest().pose.theta + toSeconds(interval) * sample.gyro.z());
    }
  }
  record(gyro_, sample.stamp, heading);
}

std::optional<Pose2> MotionProbe::wheelMotion(Timestamp from, Timestamp to, Duration extrapolation) const {
  const auto a = wheels_.at(from, extrapolation), b = wheels_.at(to, extrapolation);
  return a && b ? std::optional(between(*a, *b)) : std::nullopt;
}

std::optional<double> MotionProbe::gyroTurn(Timestamp from, Timestamp to, Duration extrapolation) const {
  const auto a = gyro_.at(from, extrapolation), b = gyro_.at(to, extrapolation);
  return a && b ? std::optional(wrapAngle(b->theta - a->theta)) : std::nullopt;
}

bool MotionProbe::checkStream(const LaserScan& scan) {
  std::uint64_t ranges = 14695981039346656037U;  // FNV-1a
  int returns = 0;
  for (const Beam& beam : scan.beams()) {
    ranges = (ranges ^ std::bit_cast<std::uint32_t>(beam.range)) * 1099511628211U;
    returns += beam.range > 0.0F;
  }
  bool repeated = false;
  if (last_scan_) {
    // A scan that is the same to the last bit is none of a robot in motion; one at rest may see it from a simulator,
    // but not before its time.
    const auto wheels = wheelMotion(*last_scan_, scan.stamp, kLongest);
    const auto turn = gyroTurn(*last_scan_, scan.stamp, kLongest);
    bool still = wheels || turn;
    if (wheels) still = wheels->translation().norm() < kStill && std::abs(wheels->theta) < kStillTurn;
    if (turn) still &= std::abs(*turn) < kStillTurn;
    const bool same = ranges == last_ranges_ && returns >= kLeastReturns;
    const Duration step = scan.stamp - *last_scan_;
    repeated = step == Duration(0) || (same && (!still || 2 * step < usual_step_));
    if (!repeated && step > Duration(0)) usual_step_ = step;
    check_.addScan(repeated, -toSeconds(step));
    if (repeated || scan.stamp < *last_scan_) findings_ = check_.findings();
  }
  last_scan_ = scan.stamp;
  last_ranges_ = ranges;
  return repeated;
}

void MotionProbe::take(const LaserScan& scan, ScanPoints& points) {
  const RangeLimits limits{std::max(scan.range_min, static_cast<float>(lidar_.range_min)),
                           std::min(scan.range_max, static_cast<float>(lidar_.range_max))};
  deskew(scan, limits, scan.stamp, lidar_.mounting(), at_rest_, points);
}

void MotionProbe::add(const LaserScan& scan) {
  if (checkStream(scan)) return;
  const Timestamp stamp = scan.stamp + fromSeconds(lidar_.time_offset);
  if (stage_ == Stage::kMatched) settle();
  const bool clock_set = newest_ - stamp > kClockStep;
  if (stamp <= newest_ && !clock_set) return;  // misdated: no motion can be told by it
  newest_ = stamp;
  if (clock_set) next_ = last_match_ = stamp;
  if (stage_ != Stage::kIdle && (clock_set || stamp - first_ > kOverdue)) stage_ = Stage::kIdle;
  if (stage_ == Stage::kIdle && stamp >= next_ && !(wheels_.empty() && gyro_.empty())) {
    take(scan, first_points_);
    first_ = stamp;
    stage_ = Stage::kBegun;
  } else if (stage_ == Stage::kBegun) {
    const auto wheels = wheelMotion(first_, stamp, kLongest);
    const auto turn = gyroTurn(first_, stamp, kLongest);
    claimed_turn_ = turn ? *turn : wheels && wheels_turn_known_ ? wheels->theta : 0.0;
    const bool turned = std::abs(claimed_turn_) > kEnoughTurn;
    const bool moved = turned || (wheels && wheels->translation().norm() > kEnoughTravel);
    if (!moved && stamp - first_ < kLongest) return;
    second_ = stamp;
    next_ = stamp + kPeriod;
    stage_ = Stage::kIdle;
    if (check_.wants(turned) || stamp - last_match_ > kLongPeriod) {
      take(scan, second_points_);
      stage_ = Stage::kEnded;
    }
  }
}

void MotionProbe::work() {
  if (stage_ != Stage::kEnded) return;
  stage_ = Stage::kIdle;
  last_match_ = second_;
  double coarseness = 1.0;
  for (ScanPoints* points : {&first_points_, &second_points_}) {
    coarseness = std::max(coarseness, estimateNormals(*points, lidar_.T_base_lidar.translation(), normals_));
  }
  reference_.clear();
  reference_.add(Pose2{}, first_points_);
  MatchResult best;
  for (const double turn : {0.0, claimed_turn_, -claimed_turn_}) {
    const MatchResult match = matchPointToLine(reference_, second_points_, Pose2{0.0, 0.0, turn}, match_);
    if (match.usable() && match.overlap > best.overlap) best = match;
    if (std::abs(claimed_turn_) < kSmallTurn) break;
  }
  if (!best.usable() || best.overlap < kOverlap) return;
  evidence_ = {.scans = best.T_ref_base, .travel_seen = coarseness < kCoarse};
  for (int blind = best.observable; blind < 3; ++blind) {
    evidence_.travel_seen = false;
    if (std::abs(best.directions(2, blind)) > kTurnIn) evidence_.turn_seen = false;
  }
  stage_ = Stage::kMatched;
}

void MotionProbe::settle() {
  stage_ = Stage::kIdle;
  evidence_.wheels = wheelMotion(first_, second_, kBeyond);
  evidence_.wheels_turn_known = wheels_turn_known_;
  evidence_.gyro_turn = gyroTurn(first_, second_, kBeyond);
  check_.add(evidence_);
  findings_ = check_.findings();
}

ScanOutcome addScan(Localizer& localizer, MotionProbe& probe, const LaserScan& scan, bool may_keep) {
  const ScanOutcome outcome = localizer.add(scan, may_keep);
  if (!outcome.stuck) probe.add(scan);
  return outcome;
}

}  // namespace slam
