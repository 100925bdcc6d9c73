// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/local_map.hpp"

#include <limits>
#include <utility>

#include "core/pose_covariance.hpp"
#include "graph/keyframe_graph.hpp"

namespace slam {

LocalMap::LocalMap(const ReferenceConfig& reference, const Pose2& T_base_lidar, bool localise_only)
    : T_base_lidar_(T_base_lidar), localise_only_(localise_only), reference_(reference) {
  for (KeptScan& scan : kept_) scan.points.reserve(LaserScan::kCapacity);
  scratch_.reserve(LaserScan::kCapacity);
  keyframes_.reserve(MapCorrection::kMaxKeyframes);
}

const ReferenceKeyframe* LocalMap::nearest(const Eigen::Vector2d& p_map) const {
  const ReferenceKeyframe* nearest = nullptr;
  double shortest = std::numeric_limits<double>::infinity();
  for (const ReferenceKeyframe& keyframe : keyframes_) {
    const double distance = (keyframe.T_map_base.translation() - p_map).squaredNorm();
    if (distance >= shortest) continue;
    shortest = distance;
    nearest = &keyframe;
  }
  return nearest;
}

void LocalMap::follow(const Eigen::Vector2d& robot) {
  const ReferenceKeyframe* keyframe = nearest(robot);
  followed_ = keyframe != nullptr ? *keyframe : ReferenceKeyframe{};
}

AnchoredPose LocalMap::anchor(const Pose2& T_map_base) const {
  const ReferenceKeyframe* keyframe = nearest(T_map_base.translation());
  if (keyframe == nullptr) return {-1, T_map_base};
  const Pose2 T_keyframe_base = between(keyframe->T_map_base, T_map_base);
  return {keyframe->id, T_keyframe_base, carried(keyframe->covariance, T_keyframe_base)};
}

void LocalMap::add(const Keyframe& keyframe, const ScanPoints& points) {
  reference_.add(keyframe.T_map_base, points, turning(keyframe.T_map_base.theta) * keyframe.sensitivity);
  if (keyframes_.size() < MapCorrection::kMaxKeyframes) {
    keyframes_.push_back({keyframe.id, keyframe.T_map_base, keyframe.covariance, keyframe.sensitivity});
  }
  newest_ = keyframe.T_map_base;
  KeptScan& scan = kept(keyframe.id);
  scan.id = keyframe.id;
  scan.points.assign(keyframe.points().begin(), keyframe.points().end());
}

void LocalMap::clear(const Eigen::Vector2d& robot) {
  reference_.clear(robot);
  keyframes_.clear();
  for (KeptScan& scan : kept_) scan.id = -1;
  newest_.reset();
  extends_ = true;
}

Pose2 LocalMap::apply(MapCorrection& correction, const Eigen::Vector2d& robot) {
  // The nearest keyframe that both references hold says how the map moved here. Those that the back end did not know
  // yet it hangs on the newest one that it knew, and so they move.
  Pose2 T_new_old;
  std::optional<Pose2> T_new_ahead;
  double nearest = std::numeric_limits<double>::infinity();
  auto corrected = correction.keyframes.begin();
  for (const ReferenceKeyframe& old : keyframes_) {
    while (corrected != correction.keyframes.end() && corrected->id < old.id) ++corrected;
    const bool common = corrected != correction.keyframes.end() && corrected->id == old.id;
    const bool ahead = old.id > correction.newest && T_new_ahead && extends_;
    if (!common && !ahead) continue;
    const Pose2 T = common ? corrected->T_map_base * old.T_map_base.inverse() : *T_new_ahead;
    if (old.id == correction.newest) T_new_ahead = T;
    const double distance = (old.T_map_base.translation() - robot).squaredNorm();
    if (distance >= nearest) continue;
    nearest = distance;
    T_new_old = T;
  }
  if (correction.T_map_session) {
    T_new_old = *correction.T_map_session;
    T_new_ahead.reset();
    extends_ = !localise_only_;
  }
  std::swap(reference_, correction.reference);
  std::swap(keyframes_, correction.keyframes);
  for (const ReferenceKeyframe& old : correction.keyframes) {
    const KeptScan& scan = kept(old.id);
    if (old.id <= correction.newest || scan.id != old.id || !extends_) continue;
    const Pose2 T_map_base = T_new_ahead.value_or(T_new_old) * old.T_map_base;
    scratch_.clear();
    for (const Keyframe::Point& point : scan.points) scratch_.push_back(scanPoint(point, T_base_lidar_));
    reference_.add(T_map_base, scratch_, turning(T_map_base.theta) * old.sensitivity);
    if (keyframes_.size() < MapCorrection::kMaxKeyframes) {
      keyframes_.push_back({old.id, T_map_base, old.covariance, old.sensitivity});
    }
  }
  if (newest_) newest_ = T_new_old * *newest_;
  return T_new_old;
}

}  // namespace slam
