// SPDX-License-Identifier: BSD-3-Clause
#include "slam/map_policy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slam {
namespace {

constexpr double kNoInformation = 1e-6;  // [1/m^2, 1/rad^2]
constexpr double kSeenFrom = 5.0;        // [m] a map holds what lies this near to its keyframes

}  // namespace

std::unique_ptr<MapPolicy> mapPolicy(const BackEndConfig& config, KeyframeMap& map, ReferenceSelector& reference) {
  if (config.localise_only) return std::make_unique<FixedMap>(config, map, reference);
  return std::make_unique<GrowingMap>(config, map, reference);
}

void GrowingMap::begin(const Keyframe& first, SessionTracker& session) {
  if (map_.undoJoin()) ++taken_back_;
  map_.begin(first);
  if (first.id > 0) {  // an edge without information keeps the graph in one piece
    map_.keyframes.graph().addEdge({.from = first.id - 1,
                                    .to = first.id,
                                    .T_from_to = between(map_.keyframes.pose(first.id - 1), first.T_map_base),
                                    .information = kNoInformation * Eigen::Matrix3d::Identity(),
                                    .kind = EdgeKind::kMotion});
  }
  session.begin(first, map_, false);
}

bool GrowingMap::isMapped(const Eigen::Vector2d& p_map) const {
  const auto near = map_.keyframes.near(p_map, kSeenFrom);
  return std::any_of(near.begin(), near.end(), [&](int id) { return map_.inMap(id); });
}

bool GrowingMap::outgrownBy(const SessionTracker& session) const {
  if (map_.given > 0) return false;
  const auto known = std::ssize(map_.idsInMap());
  return known <= config_.few_keyframes &&
         map_.keyframes.size() - session.first() > config_.outgrown * static_cast<double>(known);
}

void GrowingMap::place(const Relocalisation::Found& found, const SessionTracker& session) {
  // Joined at the map's keyframe nearest to the newest one.
  int nearest = -1;
  double shortest = std::numeric_limits<double>::infinity();
  for (int id = 0; id < session.first(); ++id) {
    const double apart = (map_.keyframes.pose(id).translation() - found.T_map_newest.translation()).norm();
    if (!map_.inMap(id) || apart >= shortest) continue;
    shortest = apart;
    nearest = id;
  }
  const int newest = map_.newest();
  if (nearest < 0) {  // the map begins with this session
    map_.take(session.first());
  } else {
    map_.join = {.first = session.first(),
                 .first_edge = static_cast<int>(map_.keyframes.graph().edges().size()),
                 .remaining = config_.join_travel,
                 .p_robot = found.T_map_newest.translation()};
    const LoopClosureConfig& closure = config_.closure;
    map_.keyframes.graph().addEdge(
        {.from = nearest,
         .to = newest,
         .T_from_to = between(map_.keyframes.pose(nearest), found.T_map_newest),
         .information = closureInformation(found.match, closure.translation_sigma, closure.rotation_sigma),
         .kind = EdgeKind::kLoopClosure});
    map_.addUncertaintyOf(nearest, session.first());
  }
  reference_.renew(map_, newest, session.number(), true);
}

void GrowingMap::extend(const Keyframe& keyframe) {
  if (keyframe.observable > 0) addMotionEdge(keyframe);
  if (config_.close_loops && !map_.join) loops_.close(map_);
}

void GrowingMap::follow(const Keyframe& keyframe) {
  if (config_.close_loops) reference_.renew(map_, keyframe.refresh ? keyframe.id : map_.newest(), keyframe.session);
}

/// Ties a keyframe to an older one that it was matched against, in the directions that the match saw.
void GrowingMap::addMotionEdge(const Keyframe& keyframe) {
  const KeyframeGraph& keyframes = map_.keyframes;
  const int newest = map_.newest();
  int nearest = -1;
  double shortest = config_.link_distance;
  for (const auto& [id, T_reference_base, covariance, sensitivity] : map_.in_reference) {
    if (id > newest - config_.link_age) break;
    const Pose2 &a = keyframes.pose(id), &b = keyframes.pose(newest);
    const double distance = (a.translation() - b.translation()).norm();
    if (distance >= shortest) continue;
    const double apart = distance + 0.5 * (1.0 - std::cos(a.theta - b.theta));
    if (apart >= shortest) continue;
    shortest = apart;
    nearest = id;
  }
  if (nearest < 0) return;
  MatchResult match;
  match.T_ref_base = keyframes.pose(newest);
  match.directions = keyframe.directions;
  match.observable = keyframe.observable;
  map_.keyframes.graph().addEdge(
      {.from = nearest,
       .to = newest,
       .T_from_to = between(keyframes.pose(nearest), keyframes.pose(newest)),
       .information = closureInformation(match, config_.link_translation_sigma, config_.link_rotation_sigma),
       .kind = EdgeKind::kMotion});
}

void FixedMap::begin(const Keyframe& first, SessionTracker& session) {
  map_.truncate();  // the session before was not part of the map
  map_.begin(first);
  session.begin(first, map_, true);
}

void FixedMap::place(const Relocalisation::Found& found, const SessionTracker& session) {
  renew(found.T_map_newest.translation(), session.number());
}

void FixedMap::follow(const Keyframe& keyframe) {
  const Pose2& T_map_base = keyframe.refresh ? keyframe.T_map_base : map_.keyframes.pose(keyframe.id);
  if ((T_map_base.translation() - centre_).norm() >= config_.renewal_travel)
    renew(T_map_base.translation(), keyframe.session);
}

void FixedMap::renew(const Eigen::Vector2d& robot, std::int32_t session) {
  auto ids = map_.keyframes.near(robot, config_.reference_radius);
  std::erase_if(ids, [&](int id) { return id >= map_.given; });
  reference_.renew(map_, robot, ids, session);
  centre_ = robot;
}

}  // namespace slam
