// SPDX-License-Identifier: BSD-3-Clause
// The localizer's keyframes: when a scan becomes one, what it says, and how corrections of the map move them.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "posegraph/keyframe_graph.hpp"
#include "slam/localizer.hpp"

namespace slam {
namespace {

constexpr double kMinStepSigma = 1e-4;  // [m, rad] keeps a step's covariance regular
constexpr double kSoon = 0.25;          // [1] of the usual motion between keyframes

}  // namespace

const Keyframe* Localizer::keepOrLook(Timestamp stamp, const Pose2& T_map_base, const MatchResult& match) {
  const KeyframeConfig& config = config_.keyframe;
  const auto movedFrom = [&](const Pose2& pose, double share = 1.0) {
    const Pose2 moved = between(pose, T_map_base);
    return std::hypot(moved.x, moved.y) > share * config.translation || std::abs(moved.theta) > share * config.rotation;
  };
  if (!extends_) {
    return movedFrom(last_look_) ? look(stamp, T_map_base) : nullptr;
  }
  if (match.overlap < config.overlap) {  // soon, but not at every scan of a robot that stands in a crowd
    const bool due = movedFrom(*last_keyframe_, kSoon) || toSeconds(stamp - last_look_stamp_) > config.look_period;
    return due ? keep(stamp, T_map_base, match) : nullptr;
  }
  if (match.familiarity < config.familiarity) {
    return movedFrom(*last_keyframe_) ? keep(stamp, T_map_base, match) : nullptr;
  }
  const bool due = movedFrom(last_look_) || toSeconds(stamp - last_look_stamp_) > config.look_period;
  return due ? look(stamp, T_map_base) : nullptr;
}

const Keyframe* Localizer::keep(Timestamp stamp, const Pose2& T_map_base, const MatchResult& match) {
  reference_.add(T_map_base, points_);
  describe(stamp, T_map_base);
  keyframe_.id = next_keyframe_++;
  ++counters_.keyframes;
  keyframe_.look = false;
  keyframe_.observable = match.observable;
  keyframe_.directions = match.directions;
  keyframe_.origin = std::exchange(origin_, KeyframeOrigin::kContinued);
  keyframe_.T_previous_base = last_keyframe_ ? between(*last_keyframe_, T_map_base) : Pose2{};
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  if (last_keyframe_) turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-last_keyframe_->theta).toRotationMatrix();
  keyframe_.step_covariance = turn * drift_ * turn.transpose();
  keyframe_.step_covariance.diagonal().array() += kMinStepSigma * kMinStepSigma;
  drift_.setZero();
  last_keyframe_ = T_map_base;
  if (reference_keyframes_.size() < MapCorrection::kMaxKeyframes)
    reference_keyframes_.push_back({keyframe_.id, T_map_base});
  newest_points_ = points_;
  KeptScan& kept = kept_[static_cast<std::size_t>(keyframe_.id) % kept_.size()];
  kept.id = keyframe_.id;
  kept.points.assign(keyframe_.points().begin(), keyframe_.points().end());
  return &keyframe_;
}

const Keyframe* Localizer::look(Timestamp stamp, const Pose2& T_map_base) {
  describe(stamp, T_map_base);
  const Anchored anchored = anchor(T_map_base);
  keyframe_.id = anchored.keyframe;
  keyframe_.T_previous_base = anchored.T_keyframe_base;
  keyframe_.look = true;
  keyframe_.origin = KeyframeOrigin::kContinued;
  return &keyframe_;
}

void Localizer::accumulateDrift(const Pose2& T_map_base, const MatchResult* match) {
  const Pose2 moved = between(drift_pose_, T_map_base);
  drift_pose_ = T_map_base;
  const double distance = std::hypot(moved.x, moved.y), turned = std::abs(moved.theta);
  const auto square = [](double value) { return value * value; };
  const DriftConfig& d = config_.drift;
  Eigen::Vector3d matched(square(d.translation) * distance, square(d.translation) * distance,
                          square(d.rotation_per_metre) * distance + square(d.rotation_per_radian) * turned);
  drift_ += matched.asDiagonal();
  if (match != nullptr && match->observable == 3) return;
  const double position = wheel_trust_.distanceFactor() * config_.ekf.wheelTranslationVariance(distance);
  const double heading = wheel_trust_.turnFactor() * config_.ekf.wheelRotationVariance(distance, turned);
  const Eigen::Matrix3d unmatched = Eigen::Vector3d(position, position, heading).asDiagonal();
  Eigen::Matrix3d blind = Eigen::Matrix3d::Identity();
  if (match != nullptr) {
    const auto unseen = match->directions.rightCols(3 - match->observable);
    blind = unseen * unseen.transpose();
  }
  drift_ += blind * unmatched * blind.transpose();
}

void Localizer::apply(MapCorrection& correction) {
  if (correction.segment != segment_) return;
  if (correction.refuted) {
    placed_ = false;
    was_placed_ = true;
    return;
  }
  // The nearest keyframe that both references hold says how the map moved here. Those that the back end did not know
  // yet it hangs on the newest one that it knew, and so they move.
  const Pose2 here = pose_.at(pose_.newestStamp()).pose();
  Pose2 T_new_old;
  std::optional<Pose2> T_new_ahead;
  double nearest = std::numeric_limits<double>::infinity();
  auto corrected = correction.keyframes.begin();
  for (const ReferenceKeyframe& old : reference_keyframes_) {
    while (corrected != correction.keyframes.end() && corrected->id < old.id) ++corrected;
    const bool common = corrected != correction.keyframes.end() && corrected->id == old.id;
    const bool ahead = old.id > correction.newest && T_new_ahead && extends_;
    if (!common && !ahead) continue;
    const Pose2 T = common ? corrected->T_map_base * old.T_map_base.inverse() : *T_new_ahead;
    if (old.id == correction.newest) T_new_ahead = T;
    const double distance = (old.T_map_base.translation() - here.translation()).squaredNorm();
    if (distance >= nearest) continue;
    nearest = distance;
    T_new_old = T;
  }
  if (correction.T_map_segment) {
    T_new_old = *correction.T_map_segment;
    T_new_ahead.reset();
    placed_ = true;
    extends_ = !config_.localise_only;
  }
  std::swap(reference_, correction.reference);
  std::swap(reference_keyframes_, correction.keyframes);
  for (const ReferenceKeyframe& old : correction.keyframes) {
    const KeptScan& kept = kept_[static_cast<std::size_t>(old.id) % kept_.size()];
    if (old.id <= correction.newest || kept.id != old.id || !extends_) continue;
    const Pose2 T_map_base = T_new_ahead.value_or(T_new_old) * old.T_map_base;
    points_.clear();
    for (const Keyframe::Point& point : kept.points) points_.push_back(scanPoint(point, config_.lidar.T_base_lidar));
    reference_.add(T_map_base, points_);
    if (reference_keyframes_.size() < MapCorrection::kMaxKeyframes)
      reference_keyframes_.push_back({old.id, T_map_base});
  }
  pose_.transform(T_new_old);
  wheel_trust_.interrupt();
  for (Pose2* pose : {&last_pose_, &last_look_, &drift_pose_}) *pose = T_new_old * *pose;
  if (last_keyframe_) *last_keyframe_ = T_new_old * *last_keyframe_;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T_new_old.theta).toRotationMatrix();
  drift_ = (turn * drift_ * turn.transpose()).eval();
}

Localizer::Anchored Localizer::anchor(const Pose2& T_map_base) const {
  const ReferenceKeyframe* nearest = nullptr;
  double shortest = std::numeric_limits<double>::infinity();
  for (const ReferenceKeyframe& keyframe : reference_keyframes_) {
    const double distance = (keyframe.T_map_base.translation() - T_map_base.translation()).squaredNorm();
    if (distance >= shortest) continue;
    shortest = distance;
    nearest = &keyframe;
  }
  return nearest == nullptr ? Anchored{-1, T_map_base}
                            : Anchored{nearest->id, between(nearest->T_map_base, T_map_base)};
}

void Localizer::describe(Timestamp stamp, const Pose2& T_map_base) {
  last_look_ = T_map_base;
  last_look_stamp_ = stamp;
  keyframe_.map_id = start_.map_id;
  keyframe_.segment = segment_;
  keyframe_.stamp = stamp;
  keyframe_.T_map_base = T_map_base;
  keyframe_.T_base_lidar = config_.lidar.T_base_lidar;
  keyframe_.size = 0;
  for (const ScanPoint& point : points_) {
    keyframe_.storage[static_cast<std::size_t>(keyframe_.size++)] = keyframePoint(point);
  }
}

}  // namespace slam
