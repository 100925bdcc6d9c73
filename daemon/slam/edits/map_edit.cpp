// SPDX-License-Identifier: BSD-3-Clause
#include "slam/edits/map_edit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/plausibility.hpp"
#include "problems/answers.hpp"

namespace slam {
namespace {

constexpr std::array<const char*, 6> kNames{"erase", "free", "wall", "zone", "room", "place"};  // by EditKind

Problem problemWithName(const std::string& name) {
  if (name.empty()) return answer::kNameMissing;
  if (name.size() > kEditLimits.name_bytes)
    return {answer::kNameLong, {static_cast<double>(name.size()), static_cast<double>(kEditLimits.name_bytes)}};
  const bool controls = std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; });
  return controls ? Problem(answer::kNameControls) : Problem();
}

int nearestTo(const Eigen::Vector2d& point, const KeyframeGraph& keyframes, std::span<const char> in_map) {
  int nearest = -1;
  double shortest = kEditLimits.farthest;
  for (int id = 0; id < keyframes.size(); ++id) {
    const double distance = (keyframes.pose(id).translation() - point).norm();
    if (in_map[static_cast<std::size_t>(id)] == 0 || distance > shortest) continue;
    shortest = distance;
    nearest = id;
  }
  return nearest;
}

}  // namespace

const char* nameOf(EditKind kind) { return kNames[static_cast<std::size_t>(kind)]; }

std::optional<EditKind> editKindOf(std::string_view name) {
  const auto known = std::find(kNames.begin(), kNames.end(), name);
  return known == kNames.end() ? std::nullopt : std::optional(static_cast<EditKind>(known - kNames.begin()));
}

Problem problemWith(const EditRequest& request) {
  const std::size_t corners = request.points.size();
  const EditKind kind = request.kind;
  const bool named = kind == EditKind::kRoom || kind == EditKind::kPlace;
  if (named || !request.name.empty()) {
    if (const Problem problem = problemWithName(request.name)) return problem;
  }
  if (!request.author.empty()) {
    if (const Problem problem = problemWithName(request.author)) return {answer::kAuthorBad, {}, {problem.words()}};
  }
  if (corners > kEditLimits.corners)
    return {answer::kManyCorners, {static_cast<double>(corners), static_cast<double>(kEditLimits.corners)}};
  for (const Eigen::Vector2d& p : request.points) {
    if (const std::string words = implausibilityOf(Pose2{p.x(), p.y(), 0.0}); !words.empty())
      return {answer::kPointAbsurd, {}, {words}};
  }
  if (kind == EditKind::kPlace) {
    if (corners != 1) return answer::kPlaceNoPoint;
    if (!isWithin(request.theta, kPlausible.turn)) return answer::kPlaceHeading;
    const bool fits = (request.sigma.array() >= 0.0).all() && (request.sigma.array() <= kEditLimits.widest_sigma).all();
    return fits ? Problem() : answer::kPlaceSigma;
  }
  if (kind == EditKind::kWall) {
    if (corners < 2) return answer::kWallShort;
    const auto same = std::adjacent_find(request.points.begin(), request.points.end());
    return same == request.points.end() ? Problem() : answer::kWallSame;
  }
  if (kind == EditKind::kRoom && corners == 1) return {};
  if (corners < 3) return {answer::kFewCorners, {static_cast<double>(corners)}};
  return crossesItself(request.points) ? Problem(answer::kOutlineCrosses) : Problem();
}

std::optional<MapEdit> anchored(const EditRequest& request, const KeyframeGraph& keyframes,
                                std::span<const char> in_map) {
  MapEdit edit;
  edit.kind = request.kind;
  edit.name = request.name;
  edit.author = request.author;
  edit.sigma = request.sigma;
  for (const Eigen::Vector2d& point : request.points) {
    const int nearest = nearestTo(point, keyframes, in_map);
    if (nearest < 0) return std::nullopt;
    edit.corners.push_back({nearest, keyframes.pose(nearest).inverse() * point});
  }
  if (request.kind == EditKind::kPlace)
    edit.theta = wrapAngle(request.theta - keyframes.pose(edit.corners.front().keyframe).theta);
  if (request.kind != EditKind::kErase) return edit;
  edit.outline = request.points;
  const Bounds bounds = Bounds::of(edit.outline), seen = bounds.grown(kEditLimits.depth_reach);
  for (int id = 0; id < keyframes.size(); ++id) {
    if (in_map[static_cast<std::size_t>(id)] == 0) continue;
    const PointTransform T(keyframes.pose(id));
    const auto& points = keyframes.scan(id)->points;
    const bool concerned = seen.holds(keyframes.pose(id).translation()) ||
                           std::any_of(points.begin(), points.end(), [&](const Keyframe::Point& point) {
                             return bounds.holds(T * Eigen::Vector2d(point.x, point.y));
                           });
    if (concerned) edit.T_keyframe_map[id] = keyframes.pose(id).inverse();
  }
  return edit;
}

Outline pointsOf(const MapEdit& edit, const KeyframeGraph& keyframes, std::span<const char> in_map) {
  Outline points;
  for (const MapEdit::Corner& corner : edit.corners) {
    if (corner.keyframe >= keyframes.size() || in_map[static_cast<std::size_t>(corner.keyframe)] == 0) return {};
    points.push_back(keyframes.pose(corner.keyframe) * corner.p_keyframe);
  }
  return points;
}

Pose2 poseOf(const MapEdit& edit, const KeyframeGraph& keyframes) {
  const auto& [keyframe, p_keyframe] = edit.corners.front();
  return keyframes.pose(keyframe) * Pose2{p_keyframe.x(), p_keyframe.y(), edit.theta};
}

}  // namespace slam
