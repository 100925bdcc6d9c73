// SPDX-License-Identifier: BSD-3-Clause
#include "slam/localizer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace slam {
namespace {

constexpr double kFastest = 0.02;                  // [s] no lidar turns faster
constexpr double kSoonest = 0.6;                   // [1] of the usual interval, between two scans
constexpr double kMoving = 0.02, kTurning = 0.05;  // [m/s], [rad/s]
constexpr std::size_t kHistoryCapacity = 1024;     // poses within one scan

/// When the beams were sampled, in any order and on either side of the scan's stamp.
struct Turn {
  Timestamp begin, end;
  Timestamp middle() const { return begin + (end - begin) / 2; }
};

Turn turnOf(const LaserScan& scan, Timestamp stamp) {
  float first = 0.0F, last = 0.0F;  // [s]
  for (const Beam& beam : scan.beams()) {
    first = std::min(first, beam.time_offset);
    last = std::max(last, beam.time_offset);
  }
  return {stamp + fromSeconds(first), stamp + fromSeconds(last)};
}

EkfConfig beginningAt(EkfConfig config, const Pose2& pose, double gyro_bias) {
  config.initial_pose = pose;
  config.initial_gyro_bias = gyro_bias;
  return config;
}
constexpr Duration kLongestPrediction = std::chrono::milliseconds(200);  // of the pose at a depth image

}  // namespace

bool isMoving(const Twist2& twist) {
  return std::hypot(twist.vx, twist.vy) > kMoving || std::abs(twist.omega) > kTurning;
}

Localizer::Localizer(const LocalizerConfig& config, Stopwatch stopwatch, const LocalizerStart& start)
    : config_(config),
      stopwatch_(stopwatch),
      start_(start),
      odometry_(beginningAt(config.ekf, {}, start.gyro_bias), config.timeline),
      pose_(beginningAt(config.ekf, start.T_map_base, start.gyro_bias), config.timeline),
      reference_(config.reference),
      search_(config.search),
      history_(kHistoryCapacity),
      wheel_trust_(config.ekf, config.wheel_trust),
      pull_watch_(config.pull_watch),
      placed_(!start.in_known_map),
      next_keyframe_(start.first_keyframe) {
  if (start.in_known_map) origin_ = KeyframeOrigin::kLost;
  config_.normals.range_sigma = config_.match.range_sigma = config_.lidar.range_sigma;
  match_ = config_.match;
  points_.reserve(LaserScan::kCapacity);
  newest_points_.reserve(LaserScan::kCapacity);
  for (KeptScan& kept : kept_) kept.points.reserve(LaserScan::kCapacity);
  reference_keyframes_.reserve(MapCorrection::kMaxKeyframes);
}

void Localizer::add(const WheelSample& sample) {
  if (!wheel_guard_.passes(sample.stamp)) return;
  WheelSample sequenced = sample;
  sequenced.stamp = wheel_stamps_.next(sample.stamp) + fromSeconds(config_.wheel_time_offset);
  odometry_.add(sequenced);
  has_wheels_ = true;
  sequenced.T_wheels_base = rescaled_wheels_.add(sample.T_wheels_base, wheel_trust_.scale());
  const bool held_back = std::exchange(wheels_held_back_, !wheel_trust_.believed());
  if (wheels_held_back_) return;
  sequenced.restarted |= held_back;  // what they told meanwhile is not made up for
  pose_.add(sequenced);
}

void Localizer::add(const ImuSample& sample) {
  if (!imu_guard_.passes(sample.stamp)) return;
  ImuSample shifted = sample;
  shifted.stamp = imu_clock_.next(sample.stamp, pose_.newestStamp()) + fromSeconds(config_.imu_time_offset);
  odometry_.add(shifted);
  pose_.add(shifted);
}

ScanOutcome Localizer::add(const LaserScan& recorded, bool may_keep) {
  ScanOutcome outcome;
  ++counters_.scans;
  if (!scan_guard_.passes(recorded.stamp)) {
    outcome.stamp = outcome.first = pose_.newestStamp();
    return outcome;
  }
  const bool repeats = repeats_.isStuck(recorded);
  if (isCopy(recorded)) {
    ++counters_.scans_repeated;
    outcome.stamp = outcome.first = last_first_ + std::max(Duration(0), recorded.stamp - last_scan_);
    return outcome;
  }
  outcome.stamp = outcome.first = scan_stamps_.next(recorded.stamp) + fromSeconds(config_.lidar.time_offset);
  last_scan_ = recorded.stamp;
  last_first_ = outcome.first;
  if (pose_.started() && outcome.first < pose_.oldestStamp()) {
    ++counters_.scans_too_late;
    return outcome;
  }

  // A lidar that repeats a turn would hold the robot in place, or take it back when it stops: its scans fit perfectly.
  outcome.stuck = stuck_ = repeats && (stuck_ || isMoving(odometry_.at(outcome.stamp).twist()));
  if (stuck_) {
    ++counters_.scans_repeated;
    return outcome;
  }

  takePoints(recorded, outcome);
  const Ekf predicted = pose_.at(outcome.stamp);
  const Pose2 guess = predicted.pose();
  if (!last_keyframe_) {
    if (static_cast<int>(points_.size()) < config_.match.min_pairs || !may_keep) return outcome;
    pose_.add(PoseMeasurement{outcome.stamp, guess, 1e-8 * Eigen::Matrix3d::Identity()});
    last_match_ = outcome.stamp;
    last_pose_ = drift_pose_ = guess;
    last_motion_ = {};
    last_odometry_ = odometry_.at(outcome.stamp).pose();
    MatchResult by_definition;
    by_definition.observable = 3;
    outcome.keyframe = keep(outcome.stamp, guess, by_definition);
    return outcome;
  }

  reference_.recentre(guess.translation());
  const Timestamp before = stopwatch_ ? stopwatch_() : Timestamp{};
  outcome.match = matchFromGuesses(outcome.stamp, predicted);
  holdIfPulled(outcome.stamp, predicted, outcome.match);
  if (stopwatch_) outcome.match_time = stopwatch_() - before;
  outcome.fused = isTold(predicted, outcome.match) && fuse(outcome.stamp, outcome.match, false);
  if (!outcome.fused) searchAround(guess, outcome);
  overlap_ = outcome.match.overlap;
  if (outcome.fused) {
    ++(outcome.match.observable == 3 ? counters_.matched : counters_.partly_observable);
    last_match_ = outcome.stamp;
    fused_overlap_ = overlap_;
    failures_ = 0;
    const Pose2 T_map_base = pose_.at(outcome.stamp).pose();
    accumulateDrift(T_map_base, &outcome.match);
    const Ekf odometry = odometry_.at(outcome.stamp);
    judgeWheels(odometry, T_map_base, outcome.match);
    last_motion_ = between(last_pose_, T_map_base);
    last_pose_ = T_map_base;
    last_odometry_ = odometry.pose();
    if (may_keep) outcome.keyframe = keepOrLook(outcome.stamp, T_map_base, outcome.match);
  } else {
    // A failed match never moves the pose: the filter carries on. When it lasts, the robot has left what the reference
    // knows, so the scan extends it from where the filter believes to be.
    ++(outcome.match.usable() ? counters_.gated : counters_.unmatched);
    if (static_cast<int>(points_.size()) < config_.match.min_pairs) return outcome;        // it says nothing
    const bool lately = toSeconds(outcome.stamp - *last_match_) < config_.degraded_after;  // a fast lidar fails often
    if (++failures_ <= config_.keyframe.max_failures || lately || !may_keep) return outcome;
    failures_ = 0;
    if (carriedAway(guess)) {
      beginSegment(KeyframeOrigin::kLost);
    } else {
      accumulateDrift(guess, nullptr);
      outcome.keyframe = keep(outcome.stamp, guess, {});
    }
  }
  return outcome;
}

/// Whether the scan was sent twice: a lidar needs its time for the next one.
bool Localizer::isCopy(const LaserScan& scan) const {
  const double soonest = std::max(kFastest, kSoonest * scan_stamps_.interval());
  return repeats_.isCopy() && toSeconds(scan.stamp - last_scan_) < soonest;
}

/// Fills points_, in base at the middle of the turn, which becomes the outcome's stamp. What the filter is wrong about
/// the speed moves the beams before it one way and those behind it the other, so that the pose found there is right. At
/// the first beam's time it would be wrong by half of the turn's error, the next speed by as much the other way, and so
/// on without end.
void Localizer::takePoints(const LaserScan& recorded, ScanOutcome& outcome) {
  const Turn turn = turnOf(recorded, outcome.first);
  outcome.stamp = turn.middle();
  pose_.fillHistory(turn.begin, turn.end, history_);
  const RangeLimits limits{std::max(recorded.range_min, static_cast<float>(config_.lidar.range_min)),
                           std::min(recorded.range_max, static_cast<float>(config_.lidar.range_max))};
  deskew(recorded, limits, outcome.first, config_.lidar.mounting(), history_, points_);
  if (turn.end > turn.begin) {
    const auto at = [this](Timestamp stamp) { return history_.at(stamp, Duration::max()).value_or(Pose2{}); };
    outcome.T_base_first = between(at(outcome.stamp), at(outcome.first));
    for (ScanPoint& point : points_) point.position = outcome.T_base_first * point.position;
  }
  const double coarseness = estimateNormals(points_, config_.lidar.T_base_lidar.translation(), config_.normals);
  // Where beams lie far apart, a point on no line is a wall that was hit once: its partner tells little of the way.
  match_.point_weight = config_.match.point_weight / coarseness;
}

const DepthSight* Localizer::add(const PseudoLaser& laser) {
  const Timestamp stamp = laser.stamp + fromSeconds(config_.depth.time_offset);
  const bool known = last_match_ && stamp >= pose_.oldestStamp() && stamp <= pose_.newestStamp() + kLongestPrediction;
  const PoseEstimate seen_from = known ? estimate(stamp) : PoseEstimate{};
  const Anchored anchored = anchor(seen_from.T_map_base);
  if (!known || seen_from.state != LocalisationState::kLocalised || anchored.keyframe < 0) {
    ++counters_.views_unplaced;
    return nullptr;
  }
  const Pose2 T_odom_base = odometry_.at(stamp).pose();
  if (last_view_ && stamp - last_view_stamp_ < fromSeconds(config_.depth.period) && stamp >= last_view_stamp_) {
    const Pose2 moved = between(*last_view_, T_odom_base);
    const bool far = std::hypot(moved.x, moved.y) >= config_.depth.translation;
    if (!far && std::abs(moved.theta) < config_.depth.rotation) return nullptr;
  }
  last_view_ = T_odom_base;
  last_view_stamp_ = stamp;
  ++counters_.views;
  sight_ = {start_.map_id, segment_, anchored.keyframe, anchored.T_keyframe_base, laser};
  return &sight_;
}

bool Localizer::carriedAway(const Pose2& predicted) const {
  if (config_.localise_only) return true;
  const Pose2 moved = between(last_pose_, predicted);
  const Eigen::Matrix3d covariance = pose_.at(pose_.newestStamp()).covariance().topLeftCorner<3, 3>();
  return std::sqrt(std::max(covariance(0, 0), covariance(1, 1))) > config_.lost_position_sigma ||
         (std::hypot(moved.x, moved.y) < config_.kidnap_distance && std::abs(moved.theta) < config_.kidnap_rotation);
}

void Localizer::beginSegment(KeyframeOrigin origin) {
  ++segment_;
  ++counters_.lost;
  was_placed_ |= placed_;
  origin_ = origin;
  placed_ = origin == KeyframeOrigin::kGiven;
  extends_ = true;
  if (config_.localise_only) next_keyframe_ = start_.first_keyframe;  // the segment before is forgotten
  reference_.clear(pose_.at(pose_.newestStamp()).pose().translation());
  reference_keyframes_.clear();
  for (KeptScan& kept : kept_) kept.id = -1;
  wheel_trust_.interrupt();
  last_keyframe_.reset();
  failures_ = 0;
}

void Localizer::judgeWheels(const Ekf& odometry, const Pose2& T_map_base, const MatchResult& match) {
  if (!has_wheels_) return;
  if (match.observable < 3 || odometry.wheelsSilent()) return wheel_trust_.interrupt();
  wheel_trust_.add(odometry.pose(), T_map_base, !odometry.gyroActive());
}

bool Localizer::fuse(Timestamp stamp, const MatchResult& match, bool confirmed) {
  return match.usable() && pose_.add(PoseMeasurement{stamp, match.T_ref_base, match.covariance, match.directions,
                                                     match.observable, confirmed}) == UpdateResult::kFused;
}

LocalisationState Localizer::state(Timestamp stamp, const Eigen::Matrix3d& covariance) const {
  if (!last_match_) return LocalisationState::kInitialising;
  if (!placed_) return was_placed_ ? LocalisationState::kLost : LocalisationState::kInitialising;
  const double sigma = std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
  if (sigma > config_.lost_position_sigma) return LocalisationState::kLost;
  const bool old = toSeconds(stamp - *last_match_) > config_.degraded_after;
  return old || failures_ > 0 ? LocalisationState::kDegraded : LocalisationState::kLocalised;
}

PoseEstimate Localizer::estimate(Timestamp stamp) const {
  const Ekf ekf = pose_.at(stamp);
  PoseEstimate estimate{.stamp = stamp,
                        .T_map_base = ekf.pose(),
                        .covariance = ekf.covariance().topLeftCorner<3, 3>(),
                        .twist = ekf.twist(),
                        .match_quality = overlap_};
  estimate.state = state(stamp, estimate.covariance);
  return estimate;
}

OdometryEstimate Localizer::odometry(Timestamp stamp) const {
  const Ekf ekf = odometry_.at(stamp);
  return {.stamp = stamp,
          .T_odom_base = ekf.pose(),
          .covariance = ekf.covariance().topLeftCorner<3, 3>(),
          .twist = ekf.twist(),
          .gyro_bias = ekf.gyroBias(),
          .slip = ekf.slip(),
          .standstill = ekf.standstill(),
          .T_map_odom = pose_.at(stamp).pose() * ekf.pose().inverse()};
}

void Localizer::setPose(const Pose2& T_map_base, const Eigen::Vector3d& sigma) {
  pose_.setPose(T_map_base, sigma);
  beginSegment(KeyframeOrigin::kGiven);
  drift_ = sigma.cwiseAbs2().asDiagonal();
}

LocalizerCounters Localizer::counters() const {
  LocalizerCounters counters = counters_;
  counters.scans_retimed = scan_stamps_.retimed();
  counters.clock_resets = scan_stamps_.clockResets() + wheel_stamps_.clockResets();
  counters.far_ahead = wheel_guard_.held() + imu_guard_.held() + scan_guard_.held();
  counters.wheels_withdrawn = static_cast<std::uint32_t>(wheel_trust_.withdrawn());
  counters.wheels_heard = wheel_trust_.believed();
  counters.wheels_scale = wheel_trust_.scale().value();
  counters.samples_late = odometry_.lateFused();
  counters.samples_too_old = odometry_.tooOld();
  return counters;
}

}  // namespace slam
