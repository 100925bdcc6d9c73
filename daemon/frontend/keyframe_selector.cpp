// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/keyframe_selector.hpp"

#include <cmath>
#include <utility>

#include "core/pose_covariance.hpp"
#include "graph/keyframe_graph.hpp"

namespace slam {
namespace {

constexpr double kMinStepSigma = 1e-4;  // [m, rad] keeps a step's covariance regular

}  // namespace

KeyframeSelector::KeyframeSelector(const KeyframeConfig& config, const LidarModel& lidar, bool localise_only,
                                   double body_margin, const FrontEndStart& start)
    : config_(config),
      T_base_lidar_(lidar.T_base_lidar),
      upside_down_(lidar.upside_down),
      map_id_(start.map_id),
      first_keyframe_(start.first_keyframe),
      localise_only_(localise_only),
      next_keyframe_(start.first_keyframe),
      origin_(start.in_known_map ? KeyframeOrigin::kLost : KeyframeOrigin::kContinued) {
  keyframe_.body_margin = body_margin;
}

void KeyframeSelector::beginSession(KeyframeOrigin origin, double heading_tolerance) {
  keyframe_.heading_tolerance = heading_tolerance;
  ++session_;
  origin_ = origin;
  if (localise_only_) next_keyframe_ = first_keyframe_;  // the session before is forgotten
}

const Keyframe* KeyframeSelector::select(const Cloud& cloud, const Pose2& T_map_base, const MatchResult& match,
                                         const Sensitivity& sensitivity, LocalMap& local_map) {
  const auto movedFrom = [&](const Pose2& pose) {
    const Pose2 moved = between(pose, T_map_base);
    return std::hypot(moved.x, moved.y) > config_.translation || std::abs(moved.theta) > config_.rotation;
  };
  if (!local_map.extends()) return movedFrom(last_refresh_) ? refresh(cloud, T_map_base, local_map) : nullptr;
  if (match.known_ratio < config_.known_ratio) {
    return movedFrom(local_map.newest()) ? keep(cloud, T_map_base, match, sensitivity, local_map) : nullptr;
  }
  if (match.observable == 3) unseen_.setZero();  // the robot is back where the map is known
  const bool long_ago = toSeconds(cloud.stamp - last_refresh_stamp_) > config_.refresh_period;
  return movedFrom(last_refresh_) || long_ago ? refresh(cloud, T_map_base, local_map) : nullptr;
}

const Keyframe* KeyframeSelector::keep(const Cloud& cloud, const Pose2& T_map_base, const MatchResult& match,
                                       const Sensitivity& sensitivity, LocalMap& local_map) {
  describe(cloud, T_map_base);
  keyframe_.sensitivity = turning(-T_map_base.theta) * sensitivity;
  keyframe_.id = next_keyframe_++;
  ++keyframes_;
  keyframe_.refresh = false;
  keyframe_.observable = match.observable;
  keyframe_.directions = match.directions;
  keyframe_.origin = std::exchange(origin_, KeyframeOrigin::kContinued);
  keyframe_.T_previous_base = local_map.empty() ? Pose2{} : between(local_map.newest(), T_map_base);
  keyframe_.step_covariance = rotated(drift_, local_map.empty() ? 0.0 : -local_map.newest().theta);
  keyframe_.step_covariance.diagonal().array() += kMinStepSigma * kMinStepSigma;
  keyframe_.covariance = local_map.anchor(T_map_base).covariance + rotated(unseen_, -T_map_base.theta);
  if (match.usable()) {
    // A match lays a scan on the walls that are drawn, so that they stay where they are. What is new is drawn with the
    // match's error, and leads the next matches astray by its share. What is wrong in each of them alike is in the
    // sensitivity.
    const double share = local_map.reference().newShare(T_map_base, cloud.points);
    keyframe_.covariance += rotated(share * share * match.covariance, -T_map_base.theta);
  }
  drift_.setZero();
  unseen_.setZero();
  local_map.add(keyframe_, cloud.points);
  return &keyframe_;
}

const Keyframe* KeyframeSelector::refresh(const Cloud& cloud, const Pose2& T_map_base, const LocalMap& local_map) {
  describe(cloud, T_map_base);
  const AnchoredPose anchored = local_map.anchor(T_map_base);
  keyframe_.id = anchored.keyframe;
  keyframe_.T_previous_base = anchored.T_keyframe_base;
  keyframe_.refresh = true;
  keyframe_.origin = KeyframeOrigin::kContinued;
  return &keyframe_;
}

void KeyframeSelector::describe(const Cloud& cloud, const Pose2& T_map_base) {
  last_refresh_ = T_map_base;
  last_refresh_stamp_ = cloud.stamp;
  keyframe_.map_id = map_id_;
  keyframe_.session = session_;
  keyframe_.stamp = cloud.stamp;
  keyframe_.T_map_base = T_map_base;
  keyframe_.T_base_lidar = T_base_lidar_;
  keyframe_.body = upside_down_ ? cloud.body.mirrored() : cloud.body;
  keyframe_.size = 0;
  for (const ScanPoint& point : cloud.points) {
    keyframe_.storage[static_cast<std::size_t>(keyframe_.size++)] = keyframePoint(point);
  }
}

void KeyframeSelector::addDrift(const Pose2& T_map_base, const MatchResult* match, const OdometryMonitor& monitor,
                                bool by_gyro) {
  const Pose2 moved = between(drift_pose_, T_map_base);
  drift_pose_ = T_map_base;
  const double distance = std::hypot(moved.x, moved.y), turned = std::abs(moved.theta);
  const DriftConfig& d = config_.drift;
  Eigen::Vector3d matched(square(d.translation) * distance, square(d.translation) * distance,
                          square(d.rotation_per_metre) * distance + square(d.rotation_per_radian) * turned);
  drift_ += matched.asDiagonal();
  unseen_ += rotated(monitor.scans.covarianceOf(moved), T_map_base.theta);
  if (match != nullptr && match->observable == 3) return;
  const double position = monitor.wheels.translationVariance(distance);
  const double heading = monitor.wheels.headingVariance(distance, turned, by_gyro);
  const Eigen::Vector3d unmatched(position, position, heading);
  Eigen::Matrix3d degenerate = Eigen::Matrix3d::Identity();
  if (match != nullptr) {
    const auto unseen = match->directions.rightCols(3 - match->observable);
    degenerate = unseen * unseen.transpose();
  }
  degenerate = (degenerate * unmatched.asDiagonal() * degenerate.transpose()).eval();
  drift_ += degenerate;
  unseen_ += degenerate;
}

void KeyframeSelector::transform(const Pose2& T_new_old) {
  last_refresh_ = T_new_old * last_refresh_;
  drift_pose_ = T_new_old * drift_pose_;
  drift_ = rotated(drift_, T_new_old.theta);
  unseen_ = rotated(unseen_, T_new_old.theta);
}

void KeyframeSelector::addTo(FrontEndCounters& counters) const {
  counters.keyframes = keyframes_;
  counters.lost = static_cast<std::uint32_t>(session_);
}

}  // namespace slam
