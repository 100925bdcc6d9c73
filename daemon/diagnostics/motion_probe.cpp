// SPDX-License-Identifier: BSD-3-Clause
#include "diagnostics/motion_probe.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/plausibility.hpp"
#include "matching/deskew.hpp"
#include "matching/normals.hpp"
#include "matching/plicp.hpp"

namespace slam {
namespace {

constexpr std::size_t kHistory = 1024;  // samples of wheels and of the gyro

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
void record(PoseHistory& history, Timestamp stamp, const Pose2& pose, Duration clock_step) {
  if (!history.empty() && history.newest().stamp - stamp > clock_step) history.clear();
  history.push(stamp, pose);
}

}  // namespace

MotionProbe::MotionProbe(const FrontEndConfig& config, const MotionProbeConfig& probe)
    : config_(probe),
      lidar_(config.lidar),
      wheel_offset_(fromSeconds(config.intake.wheel_time_offset)),
      imu_offset_(fromSeconds(config.intake.imu_time_offset)),
      normals_(config.preprocessor.normals),
      match_(config.match),
      wheels_(kHistory),
      gyro_(kHistory),
      reference_(smallReference(config.reference)) {
  normals_.range_sigma = match_.range_sigma = lidar_.range_sigma;
  first_points_.reserve(LaserScan::kCapacity);
  second_points_.reserve(LaserScan::kCapacity);
}

void MotionProbe::add(const WheelSample& sample) {
  if (!isPlausible(sample)) return;
  wheels_turn_known_ = sample.turn_rate_known;
  record(wheels_, sample.stamp + wheel_offset_, sample.T_wheels_base, config_.clock_step);
}

void MotionProbe::add(const ImuSample& recorded) {
  if (!isPlausible(recorded)) return;
  ImuSample sample = recorded;
  sample.stamp += imu_offset_;
  Pose2 heading;
  if (!gyro_.empty()) {
    const Duration interval = sample.stamp - gyro_.newest().stamp;
    if (interval > config_.gyro_gap) {
      gyro_.clear();
    } else {
      heading.theta = wrapAngle(gyro_.newest().pose.theta + toSeconds(interval) * sample.gyro.z());
    }
  }
  record(gyro_, sample.stamp, heading, config_.clock_step);
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
    const auto wheels = wheelMotion(*last_scan_, scan.stamp, config_.longest);
    const auto turn = gyroTurn(*last_scan_, scan.stamp, config_.longest);
    bool still = wheels || turn;
    if (wheels) still = wheels->translation().norm() < config_.still && std::abs(wheels->theta) < config_.still_turn;
    if (turn) still &= std::abs(*turn) < config_.still_turn;
    const bool same = ranges == last_ranges_ && returns >= config_.least_returns;
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
  deskew(scan, lidar_.limitsFor(scan), scan.stamp, lidar_.mounting(), at_rest_, points);
}

void MotionProbe::add(const LaserScan& scan, Duration delay) {
  if (checkStream(scan)) return;
  const Timestamp stamp = scan.stamp + fromSeconds(lidar_.time_offset) + delay;
  if (stage_ == Stage::kMatched) settle();
  const bool clock_set = newest_ - stamp > config_.clock_step;
  if (stamp <= newest_ && !clock_set) return;  // misdated: no motion can be told by it
  newest_ = stamp;
  if (clock_set) next_ = last_match_ = stamp;
  if (stage_ != Stage::kIdle && (clock_set || stamp - first_ > config_.overdue)) stage_ = Stage::kIdle;
  if (stage_ == Stage::kIdle && stamp >= next_ && !(wheels_.empty() && gyro_.empty())) {
    take(scan, first_points_);
    first_ = stamp;
    stage_ = Stage::kBegun;
  } else if (stage_ == Stage::kBegun) {
    const auto wheels = wheelMotion(first_, stamp, config_.longest);
    const auto turn = gyroTurn(first_, stamp, config_.longest);
    claimed_turn_ = turn ? *turn : wheels && wheels_turn_known_ ? wheels->theta : 0.0;
    const bool turned = std::abs(claimed_turn_) > config_.enough_turn;
    const bool moved = turned || (wheels && wheels->translation().norm() > config_.enough_travel);
    if (!moved && stamp - first_ < config_.longest) return;
    second_ = stamp;
    next_ = stamp + config_.period;
    stage_ = Stage::kIdle;
    if (check_.wants(turned) || stamp - last_match_ > config_.long_period) {
      take(scan, second_points_);
      stage_ = Stage::kEnded;
    }
  }
}

void MotionProbe::work() {
  if (stage_ != Stage::kEnded) return;
  stage_ = Stage::kIdle;
  last_match_ = second_;
  double relative_spacing = 1.0;
  for (ScanPoints* points : {&first_points_, &second_points_}) {
    relative_spacing =
        std::max(relative_spacing, estimateNormals(*points, lidar_.T_base_lidar.translation(), normals_));
  }
  reference_.clear();
  reference_.add(Pose2{}, first_points_);
  MatchResult best;
  for (const double turn : {0.0, claimed_turn_, -claimed_turn_}) {
    const MatchResult match = matchPointToLine(reference_, second_points_, Pose2{0.0, 0.0, turn}, match_);
    if (match.usable() && match.overlap > best.overlap) best = match;
    if (std::abs(claimed_turn_) < config_.small_turn) break;
  }
  if (!best.usable() || best.overlap < config_.overlap) return;
  evidence_ = {.scans = best.T_ref_base, .travel_seen = relative_spacing < config_.coarse};
  for (int degenerate = best.observable; degenerate < 3; ++degenerate) {
    evidence_.travel_seen = false;
    if (std::abs(best.directions(2, degenerate)) > config_.turn_in) evidence_.turn_seen = false;
  }
  stage_ = Stage::kMatched;
}

void MotionProbe::settle() {
  stage_ = Stage::kIdle;
  evidence_.wheels = wheelMotion(first_, second_, config_.beyond);
  evidence_.wheels_turn_known = wheels_turn_known_;
  evidence_.gyro_turn = gyroTurn(first_, second_, config_.beyond);
  evidence_.seconds = toSeconds(second_ - first_);
  check_.add(evidence_);
  findings_ = check_.findings();
}

SensorFindings findingsOf(const MotionProbe& probe, const FrontEnd& front_end, const SensorCheckConfig& config) {
  SensorFindings findings =
      withMount(withGyro(withDistances(probe.findings(), front_end.wheelScale()), front_end.gyroVerdict()),
                front_end.mountError());
  const ScanInterpreter& beams = front_end.interpreter();
  if (const int degrees = beams.body().degrees(); degrees >= config.few_degrees)
    findings.add(SensorFault::kMovesWithRobot, degrees, beams.body().middle());
  if (const auto codes = beams.noReturnCodes(); !codes.empty())
    findings.add(SensorFault::kNoReturnCodes, static_cast<double>(*std::max_element(codes.begin(), codes.end())),
                 static_cast<double>(codes.size()));
  if (beams.rangeNoise().tooNoisy()) findings.add(SensorFault::kRangesScatter, beams.rangeNoise().sigma());
  if (beams.timesMissing()) findings.add(SensorFault::kBeamTimesMissing);
  if (const auto ahead = front_end.counters().far_ahead; ahead >= static_cast<std::uint32_t>(config.least_count))
    findings.add(SensorFault::kStampsAlone, static_cast<double>(ahead));
  if (front_end.wheelsDead()) findings.add(SensorFault::kWheelsDead);
  const LidarDelay& delay = front_end.lidarDelay();
  if (const auto off = delay.estimate(); off && delay.used() != Duration(0))
    findings.add(SensorFault::kLidarDelay, toSeconds(delay.used()), off->sigma);
  return findings;
}

}  // namespace slam
