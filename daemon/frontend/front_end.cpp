// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/front_end.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "core/plausibility.hpp"
#include "core/pose_covariance.hpp"
#include "matching/systematic.hpp"

namespace slam {
namespace {

constexpr Duration kLongestPrediction = std::chrono::milliseconds(200);  // of the pose at a depth image

FrontEndConfig withRangeSigma(FrontEndConfig config) {
  config.preprocessor.normals.range_sigma = config.match.range_sigma = config.lidar.range_sigma;
  return config;
}

EkfConfig beginningAt(EkfConfig config, const Pose2& pose, double gyro_bias) {
  config.initial_pose = pose;
  config.initial_gyro_bias = gyro_bias;
  return config;
}

bool isFarOff(const Pose2& T_map_base) {
  return !isWithin(T_map_base.x, kPlausible.farthest) || !isWithin(T_map_base.y, kPlausible.farthest);
}

EkfConfig smooth(EkfConfig config) {
  config.smooth = true;
  return config;
}

}  // namespace

FrontEnd::FrontEnd(const FrontEndConfig& config, Stopwatch stopwatch, const FrontEndStart& start)
    : config_(withRangeSigma(config)),
      odometry_(smooth(beginningAt(config.ekf, {}, start.gyro_bias)), config.timeline),
      pose_(beginningAt(config.ekf, start.T_map_base, start.gyro_bias), config.timeline),
      intake_(config_.intake, config_.lidar),
      monitor_{WheelMonitor(config.ekf, config.wheel_monitor),
               GyroMonitor(config.ekf, config.gyro_monitor),
               ScanMonitor(config.ekf, config.scan_monitor),
               HeadingMonitor(config.heading_monitor),
               MountMonitor(config.lidar.systematic.mountCovariance(), config.mount_monitor),
               LidarDelay(config.lidar_delay)},
      preprocessor_(config_.preprocessor, config_.lidar, config_.match, start.body),
      local_map_(config_.reference, config_.lidar.T_base_lidar, config_.localise_only),
      registration_(config_.registration, config_.search, config_.search_window, stopwatch),
      validator_(config_.validator, config_.dynamic_object_gate, config_.search_window,
                 config_.lidar.T_base_lidar.translation()),
      tracking_(config_.tracking, config_.localise_only, start.in_known_map),
      keyframes_(config_.keyframe, config_.lidar, config_.localise_only,
                 config_.preprocessor.interpreter.body.translation, start),
      views_(config.depth) {}

void FrontEnd::add(const WheelSample& recorded) {
  const auto sample = intake_.accept(recorded);
  if (!sample) return;
  if (!std::exchange(lifted_, sample->lifted) && lifted_) leaveTheFloor(sample->stamp);
  if (monitor_.gyro.add(*sample, gyroBias())) pose_.loseGyro();  // the odometry would jump
  odometry_.add(*sample);
  if (const auto corrected = monitor_.wheels.add(*sample, tracking_.unmatched(sample->stamp))) pose_.add(*corrected);
}

void FrontEnd::add(const ImuSample& recorded) {
  const auto sample = intake_.accept(recorded, pose_.newestStamp());
  if (!sample) return;
  monitor_.delay.addGyro(sample->stamp, sample->gyro.z());
  const ImuSample assessed = monitor_.gyro.add(*sample);
  odometry_.add(assessed);
  pose_.add(assessed);
}

ScanOutcome FrontEnd::add(const LaserScan& recorded, bool may_keep) {
  const ScanOutcome outcome = track(recorded, may_keep);
  local_map_.follow(pose_.poseAt(outcome.stamp).translation());
  return outcome;
}

ScanOutcome FrontEnd::track(const LaserScan& recorded, bool may_keep) {
  const SensorIntake::Scan taken =  // order of stamps, copies, a stuck lidar
      intake_.accept(recorded, pose_, odometry_, preprocessor_.interpreter().noReturnCodes());
  ScanOutcome outcome;
  outcome.stamp = outcome.first = taken.first;
  outcome.stuck = taken.stuck;
  outcome.misdated = taken.misdated;
  outcome.scan = &recorded;
  if (!taken.accepted) return outcome;
  if (lifted_) return outcome;  // seen from another height or tilted: of no use for pose and map

  const bool was_noisy = interpreter().rangeNoise().tooNoisy();
  const Cloud& cloud =  // deskewed to mid-turn, with normals
      preprocessor_.process(recorded, taken.first, taken.interval, pose_, odometry_);
  if (!was_noisy && interpreter().rangeNoise().tooNoisy()) endDoubt();
  outcome.scan = cloud.scan;
  outcome.stamp = cloud.stamp;
  outcome.T_base_first = cloud.T_base_first;
  const Prediction predicted{pose_.at(cloud.stamp), odometry_.at(cloud.stamp)};
  if (isFarOff(predicted.pose.pose())) {
    leaveFarPlace();
    return outcome;
  }
  // Neither wheels nor gyro show a lift's way, and its next floor may look like the one before.
  if (tracking_.begun() && interpreter().cabin().opened())
    beginSession(tracking_.placed() ? KeyframeOrigin::kAssumed : KeyframeOrigin::kLost);
  if (local_map_.empty()) {
    outcome.keyframe = may_keep ? beginMap(cloud, predicted) : nullptr;
    return outcome;
  }

  local_map_.recentre(predicted.pose.pose().translation());
  const WheelMonitor& wheels = monitor_.wheels;
  MatchResult& match = outcome.match;
  match = registration_.align(cloud, local_map_, predicted, tracking_, wheels.reliability());  // PL-ICP [Censi 2008]
  outcome.match_time = registration_.matchTime();
  validator_.removeDynamicBias(match, cloud, local_map_, predicted, wheels);  // people who walk beside the robot

  // A scan that contradicts itself has walls in the open wherever it is, and so has one at a place that is guessed.
  const bool by_wheels = wheels.reliability() >= WheelReliability::kReliable;
  if (validator_.wallsInTheOpen(cloud) && by_wheels && !monitor_.heading.contradicts()) {
    beginSession(KeyframeOrigin::kLost);
    return outcome;
  }

  outcome.fused = validator_.acceptTracking(match, cloud, local_map_, predicted.pose, tracking_) &&
                  fuse(cloud, predicted, match, false);            // (15)-(17)
  if (!outcome.fused) recoverBySearch(cloud, predicted, outcome);  // correlative [Olson 2009], stricter test
  compareTurns(cloud.stamp, match, !taken.retimed);
  outcome.keyframe =
      outcome.fused ? follow(cloud, predicted, match, may_keep) : coast(cloud, predicted, match, may_keep);
  return outcome;
}

/// The first scan lies where the filter is, by definition.
const Keyframe* FrontEnd::beginMap(const Cloud& cloud, const Prediction& predicted) {
  if (!isInformative(cloud)) return nullptr;
  const Pose2 T_map_base = predicted.pose.pose();
  pose_.add(PoseMeasurement{cloud.stamp, T_map_base, 1e-8 * Eigen::Matrix3d::Identity()});
  tracking_.begin(cloud.stamp, T_map_base, predicted.odometry.pose());
  keyframes_.begin(T_map_base);
  monitor_.mount.beginMap(T_map_base);
  MatchResult by_definition;
  by_definition.observable = 3;
  return keyframes_.keep(cloud, T_map_base, by_definition, Sensitivity::Zero(), local_map_);
}

void FrontEnd::recoverBySearch(const Cloud& cloud, const Prediction& predicted, ScanOutcome& outcome) {
  const MatchResult found = registration_.search(cloud, local_map_, predicted.pose.pose(), tracking_.failures());
  if (!validator_.acceptSearch(found, cloud, local_map_, predicted.pose, tracking_)) return;
  outcome.match = found;
  // A place off the prediction is believed where wheels alone predicted, or where no such scan can have been taken.
  const bool from_afar =
      carried_ || !predicted.pose.gyroActive() || validator_.kidnapped(predicted.pose.pose(), cloud, local_map_);
  outcome.fused = fuse(cloud, predicted, found, from_afar);
}

const Keyframe* FrontEnd::follow(const Cloud& cloud, const Prediction& predicted, const MatchResult& match,
                                 bool may_keep) {
  const Ekf& ekf = pose_.upTo(cloud.stamp);  // the match was fused at this stamp
  carried_ = false;
  const Pose2 T_map_base = ekf.pose();
  // A scan that sees walls along the robot's way alone leaves it open where on it: no match from there is the only one.
  if (tracking_.placed() && tracking_.unplaced(ekf.covariance().topLeftCorner<3, 3>())) {
    beginSession(KeyframeOrigin::kLost);
    return nullptr;
  }
  shareGyroBias();
  monitor_.scans.compare(predicted.odometry, T_map_base, match.covariance, monitor_.wheels, monitor_.heading);
  monitor_.heading.compare(monitor_.gyro, cloud.stamp, predicted.odometry.standstill(), T_map_base.theta,
                           ekf.covariance()(2, 2));
  keyframes_.addDrift(T_map_base, &match, monitor_, predicted.odometry.gyroActive());
  // Counters that died are no wrong radius.
  monitor_.wheels.compare(predicted.odometry, T_map_base, match.observable == 3 && !ekf.wheelsDead());
  monitor_.mount.compare(predicted.odometry.pose(), T_map_base, match.observable == 3);
  tracking_.follow(match, cloud.stamp, T_map_base, predicted.odometry.pose());
  return may_keep ? keyframes_.select(cloud, T_map_base, match, ekf.sensitivity(), local_map_) : nullptr;
}

/// Scans that turn out to be noise were wrong where they contradicted wheels and gyro.
void FrontEnd::endDoubt() {
  const Ekf& ekf = pose_.newest();
  pose_.setPose(ekf.pose(), ekf.covariance().diagonal().head<3>().cwiseSqrt());
}

/// By what the scan says itself: the filter's pose is the gyro's, too.
/// @param stamped as the lidar was: else the turn says nothing of its delay
void FrontEnd::compareTurns(Timestamp stamp, const MatchResult& match, bool stamped) {
  if (!match.usable() || match.observable < 3 || match.overlap < config_.validator.trusted_overlap) {
    monitor_.delay.interrupt();
    return monitor_.gyro.interrupt();
  }
  // Wheels that are wrong bend the scans.
  if (!stamped || monitor_.wheels.reliability() == WheelReliability::kRejected) {
    monitor_.delay.interrupt();
  } else if (const auto bias = monitor_.delay.addScan(stamp, match.T_ref_base.theta)) {
    intake_.setLidarOffset(fromSeconds(config_.lidar.time_offset) + monitor_.delay.used());
    monitor_.interrupt();
    monitor_.gyro.forget();
    return correctGyroBias(*bias);
  }
  if (const auto bias = monitor_.gyro.compare(stamp, match.T_ref_base.theta, gyroBias())) correctGyroBias(*bias);
}

void FrontEnd::correctGyroBias(const GyroBias& bias) {
  odometry_.add(bias);
  pose_.add(bias);
}

/// The scans have told more of the bias than standstill alone can.
void FrontEnd::shareGyroBias() {
  const Ekf& newest = pose_.newest();
  if (newest.gyroActive()) odometry_.add(newest.gyroBiasEstimate());
}

/// A failed match never moves the pose: the filter carries on. When it lasts, the robot was carried away if the scan
/// sees through the walls around. Else it has left what the reference knows, and the scan extends it from there.
const Keyframe* FrontEnd::coast(const Cloud& cloud, const Prediction& predicted, const MatchResult& match,
                                bool may_keep) {
  if (!tracking_.fail(match, cloud.stamp, isInformative(cloud), may_keep)) return nullptr;
  const Pose2 T_map_base = predicted.pose.pose();
  // A scan that contradicts itself sees through walls wherever it is.
  const bool kidnapped = !monitor_.heading.contradicts() && validator_.kidnapped(T_map_base, cloud, local_map_);
  if (kidnapped || carried_ || tracking_.lost(pose_.newest().covariance().topLeftCorner<3, 3>())) {
    beginSession(KeyframeOrigin::kLost);
    return nullptr;
  }
  keyframes_.addDrift(T_map_base, nullptr, monitor_, predicted.odometry.gyroActive());
  return keyframes_.keep(cloud, T_map_base, {}, predicted.pose.sensitivity(), local_map_);
}

bool FrontEnd::isInformative(const Cloud& cloud) const {
  return static_cast<int>(cloud.points.size()) >= config_.match.min_pairs;
}

bool FrontEnd::fuse(const Cloud& cloud, const Prediction& predicted, const MatchResult& match, bool bypass_gate) {
  if (!match.usable()) return false;
  const Sensitivity sensitivity =  // [Schmidt 1966]
      sensitivityOf(local_map_.reference(), cloud.points, match, predicted.pose.sensitivity(), cloud.match);
  const Eigen::Matrix3d covariance = match.covariance + monitor_.heading.matchError();
  return pose_.add(PoseMeasurement{cloud.stamp, match.T_ref_base, covariance, match.directions, sensitivity,
                                   match.observable, bypass_gate}) == UpdateResult::kFused;
}

const DepthObservation* FrontEnd::add(const PseudoLaser& laser) {
  const Timestamp stamp = laser.stamp + fromSeconds(config_.depth.time_offset);
  const bool known =
      tracking_.begun() && stamp >= pose_.oldestStamp() && stamp <= pose_.newestStamp() + kLongestPrediction;
  if (!known) return views_.leaveOut();
  const PoseEstimate seen_from = estimate(stamp);
  const AnchoredPose anchored = anchor(seen_from.T_map_base);
  if (seen_from.state != LocalisationState::kLocalised || anchored.keyframe < 0) return views_.leaveOut();
  return views_.select(laser, stamp, odometry_.poseAt(stamp), mapId(), session(), anchored);
}

void FrontEnd::setPose(const Pose2& T_map_base, const Eigen::Vector3d& sigma) {
  pose_.setPose(T_map_base, sigma);
  beginSession(KeyframeOrigin::kGiven);
  local_map_.follow(pose_.newest().pose().translation());
}

/// Nothing but odometry that is wrong for long leads beyond where any map reaches: the robot may be anywhere. Its
/// session begins at the map's origin, as good as any other place until it is found.
void FrontEnd::leaveFarPlace() {
  ++far_off_;
  const Pose2 far = pose_.newest().pose(), T_new_old{-far.x, -far.y, 0.0};
  pose_.transform(T_new_old);
  tracking_.transform(T_new_old);
  keyframes_.transform(T_new_old);
  beginSession(KeyframeOrigin::kLost);
  local_map_.follow(pose_.newest().pose().translation());
}

/// Who lifts a robot may put it down anywhere around: the next scan that counts must be a find.
void FrontEnd::leaveTheFloor(Timestamp stamp) {
  if (!tracking_.begun()) return;
  tracking_.fail({}, stamp, true, false);
  carried_ = true;
}

void FrontEnd::beginSession(KeyframeOrigin origin) {
  // A gyro turns with who carries the robot, but not with who gives its pose.
  double heading_tolerance = std::numbers::pi;
  const Ekf& newest = pose_.newest();
  if (origin == KeyframeOrigin::kLost && monitor_.gyro.reliable()) {
    heading_tolerance = validator_.headingTolerance(newest);
    if (!tracking_.placed()) heading_tolerance += keyframes_.headingTolerance();
  }
  carried_ = false;
  preprocessor_.forgetPlace();
  validator_.begin();
  using Place = TrackingState::Place;
  tracking_.beginSession(origin == KeyframeOrigin::kGiven     ? Place::kKnown
                         : origin == KeyframeOrigin::kAssumed ? Place::kAssumed
                                                              : Place::kNoMore);
  keyframes_.beginSession(origin, heading_tolerance);
  local_map_.clear(newest.pose().translation());
  monitor_.reset();
}

void FrontEnd::apply(MapCorrection& correction) {
  if (correction.session != session()) return;
  if (correction.refuted) return tracking_.refute();
  const Pose2 T_new_old = local_map_.apply(correction, pose_.newest().pose().translation());
  if (correction.T_map_session) tracking_.place();
  pose_.transform(T_new_old);
  monitor_.interrupt();
  monitor_.mount.transform(T_new_old);
  if (correction.T_map_session) monitor_.mount.beginMap({});
  tracking_.transform(T_new_old);
  keyframes_.transform(T_new_old);
  local_map_.follow(pose_.newest().pose().translation());
}

PoseEstimate FrontEnd::estimate(Timestamp stamp) const {
  const Ekf ekf = pose_.at(stamp);
  PoseEstimate estimate{.stamp = stamp,
                        .T_map_base = ekf.pose(),
                        .covariance = ekf.covariance().topLeftCorner<3, 3>(),
                        .twist = ekf.twist(),
                        .match_quality = tracking_.overlap()};
  // Wheels without a gyro beside them are as likely wrong as the scans.
  const bool contradicted = (monitor_.scans.contradicts() && ekf.gyroActive()) || monitor_.heading.contradicts();
  // What follows are errors of the map: the robot's place among its walls is as sure as the filter has it.
  estimate.state = tracking_.state(stamp, pose_.newestStamp(), estimate.covariance, contradicted);
  if (carried_) estimate.state = LocalisationState::kLost;
  const Eigen::Matrix3d of_map = local_map_.covarianceAt(estimate.T_map_base) + monitor_.scans.covariance();
  estimate.covariance += rotated(of_map, estimate.T_map_base.theta);
  const Sensitivity sensitivity = ekf.sensitivity();
  estimate.covariance += sensitivity * config_.lidar.systematic.covariance() * sensitivity.transpose();
  estimate.covariance += monitor_.mount.covarianceAt(estimate.T_map_base);
  estimate.covariance += tracking_.tension();  // it stays the same from scan to scan, so that no mean lessens it
  // Wheels alone do not see a slip within a scan, which is bent by it.
  if (!ekf.gyroActive())
    estimate.covariance(2, 2) += config_.ekf.wheelRotationVariance(0.0, 0.5 * std::abs(tracking_.lastMotion().theta));
  return estimate;
}

OdometryEstimate FrontEnd::odometry(Timestamp stamp) const {
  const Ekf ekf = odometry_.at(stamp);
  return {.stamp = stamp,
          .T_odom_base = ekf.pose(),
          .covariance = ekf.covariance().topLeftCorner<3, 3>(),
          .twist = ekf.twist(),
          .gyro_bias = ekf.gyroBias(),
          .slip = ekf.slip(),
          .standstill = ekf.standstill(),
          .T_map_odom = pose_.poseAt(stamp) * ekf.pose().inverse()};
}

TrackingReport FrontEnd::trackingReport(Timestamp stamp) const {
  const RangeNoiseWatch& noise = interpreter().rangeNoise();
  return {.begun = tracking_.begun(),
          .placed = tracking_.placed(),
          .assumed = tracking_.assumed(),
          .silent = tracking_.silent(stamp, pose_.newestStamp()),
          .failures = tracking_.failures(),
          .points = preprocessor_.points(),
          .needed = config_.match.min_pairs,
          .range_noise = noise.tooNoisy() ? noise.sigma() : 0.0,
          .contradiction = std::sqrt(monitor_.scans.covariance().topLeftCorner<2, 2>().trace()),
          .scan_drift = monitor_.heading.drift()};
}

FrontEndCounters FrontEnd::counters() const {
  FrontEndCounters counters;
  intake_.addTo(counters);
  tracking_.addTo(counters);
  keyframes_.addTo(counters);
  views_.addTo(counters);
  counters.searched = registration_.searched();
  counters.scans_held = validator_.held();
  counters.wheels_rejected = static_cast<std::uint32_t>(monitor_.wheels.rejections());
  counters.wheels_reliable = monitor_.wheels.reliable();
  counters.gyro_rejected = static_cast<std::uint32_t>(monitor_.gyro.rejections());
  counters.wheels_scale = monitor_.wheels.scale().value();
  counters.far_off = far_off_;
  counters.samples_late = odometry_.lateFused();
  counters.samples_too_old = odometry_.tooOld();
  return counters;
}

}  // namespace slam
