// SPDX-License-Identifier: BSD-3-Clause
#include "slam/reference_selector.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr double kTake = 2.0, kLeave = 3.0;  // times active_sigma: of keyframes taken into and out of the reference

}  // namespace

void ReferenceSelector::renew(KeyframeMap& map, int anchor, std::int32_t session, bool stale) {
  // Three thresholds, so that one keyframe after another does not renew it: what is known well must be in it, what has
  // become unknown must not, and what lies between comes along when it is renewed anyway.
  const Eigen::Vector2d robot = map.keyframes.pose(anchor).translation();
  stale |= !map.reference_cleared;
  const auto variance = [&](double factor) { return std::pow(factor * config_.closure.active_sigma, 2); };
  std::vector<int> wanted;
  known_.clear();
  for (const auto& reached : map.keyframes.graph().reach(anchor, variance(kLeave))) {
    known_.insert(reached.node);
    const double distance = (map.keyframes.pose(reached.node).translation() - robot).norm();
    if (distance > config_.reference_radius) continue;
    if (reached.position_variance < variance(kTake)) wanted.push_back(reached.node);
    stale |= reached.position_variance < variance(1.0) && distance < config_.renewal_radius &&
             !map.inReference(reached.node);
  }
  for (const auto& [id, T_reference_base, covariance, sensitivity] : map.in_reference) {
    const Pose2& pose = map.keyframes.pose(id);
    const Eigen::Vector2d position = pose.translation();
    stale |= (position - T_reference_base.translation()).norm() > config_.renewal_shift ||
             std::abs(wrapAngle(pose.theta - T_reference_base.theta)) > config_.renewal_turn ||
             (!known_.contains(id) && (position - robot).norm() < config_.renewal_radius);
    if (stale) break;
  }
  if (!stale) return;
  std::sort(wanted.begin(), wanted.end());
  renew(map, robot, wanted, session);
}

void ReferenceSelector::renew(KeyframeMap& map, const Eigen::Vector2d& robot, std::span<const int> ids,
                              std::int32_t session) {
  begin(session);
  due_->reference.clear(robot);
  map.keyframes.addTo(due_->reference, ids);
  due_->keyframes.clear();
  for (const int id : ids) {
    const StoredScan& scan = *map.keyframes.scan(id);
    due_->keyframes.push_back({id, map.keyframes.pose(id), scan.covariance, scan.sensitivity});
  }
  map.in_reference = due_->keyframes;
  map.reference_cleared = true;
  due_->newest = map.newest();
  ++made_;
}

void ReferenceSelector::refute(std::int32_t session) {
  begin(session);
  due_->refuted = true;
}

void ReferenceSelector::begin(std::int32_t session) {
  due_ = spare_ ? std::move(spare_) : std::make_unique<MapCorrection>(config_.reference);
  due_->T_map_session.reset();
  due_->refuted = false;
  due_->session = session;
}

}  // namespace slam
