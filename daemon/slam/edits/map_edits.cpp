// SPDX-License-Identifier: BSD-3-Clause
#include "slam/edits/map_edits.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "problems/answers.hpp"

namespace slam {
namespace {

/// Whether an edit erases a point of a keyframe, whose points it concerns.
bool erases(const MapEdit& edit, const PointTransform& T_map_keyframe, const Keyframe::Point& point) {
  return holds(edit.outline, T_map_keyframe * Eigen::Vector2d(point.x, point.y));
}

bool samePlaces(std::span<const Keyframe::Point> a, std::span<const Keyframe::Point> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& p, const auto& q) { return p.x == q.x && p.y == q.y; });
}

}  // namespace

MapEdit* MapEdits::find(int id) {
  const auto known = std::find_if(edits.begin(), edits.end(), [&](const MapEdit& edit) { return edit.id == id; });
  return known == edits.end() ? nullptr : &*known;
}

Problem MapEdits::carryOut(const EditCommand& command, const KeyframeGraph& keyframes, std::span<const char> in_map,
                           int* concerned) {
  switch (command.kind) {
    case EditCommand::kAdd:
      if (const Problem problem = add(command, keyframes, in_map)) return problem;
      *concerned = made;
      break;
    case EditCommand::kRemove: {
      if (const MapEdit* const edit = find(command.id); edit == nullptr || !edit->active)
        return {answer::kNoEdit, {static_cast<double>(command.id)}};
      take({command.id, true});
      find(command.id)->active = false;
      *concerned = command.id;
      break;
    }
    case EditCommand::kUndo:
      if (done == 0) return answer::kNothingToUndo;
      --done;
      *concerned = steps[done].id;
      find(*concerned)->active = steps[done].removes;
      break;
    case EditCommand::kRedo:
      if (done == steps.size()) return answer::kNothingUndone;
      *concerned = steps[done].id;
      find(*concerned)->active = !steps[done].removes;
      ++done;
      break;
  }
  ++revision;
  return {};
}

Problem MapEdits::add(const EditCommand& command, const KeyframeGraph& keyframes, std::span<const char> in_map) {
  if (const Problem problem = problemWith(command.request)) return problem;
  const auto active = std::count_if(edits.begin(), edits.end(), [](const MapEdit& edit) { return edit.active; });
  if (active >= static_cast<std::ptrdiff_t>(kEditLimits.edits))
    return {answer::kMostEdits, {static_cast<double>(active)}};
  if (std::find(in_map.begin(), in_map.end(), 1) == in_map.end()) return answer::kNoMapYet;
  auto edit = anchored(command.request, keyframes, in_map);
  if (!edit) return {answer::kPointFar, {kEditLimits.farthest}};
  edit->id = ++made;
  edit->active = true;
  edit->utime = command.utime;
  edits.push_back(std::move(*edit));
  take({made, false});
  return {};
}

/// What was undone cannot come back behind a new step, and the oldest steps cannot be undone for ever.
void MapEdits::take(Step step) {
  steps.resize(done);
  steps.push_back(step);
  forgetUndone();
}

void MapEdits::forgetUndone() {
  steps.erase(steps.begin(), steps.end() - static_cast<std::ptrdiff_t>(std::min(steps.size(), kEditLimits.steps)));
  done = steps.size();
  std::erase_if(edits, [this](const MapEdit& edit) {
    return !edit.active && std::none_of(steps.begin(), steps.end(), [&](const Step& s) { return s.id == edit.id; });
  });
}

void MapEdits::append(const MapEdits& other, int first, double turn) {
  const int before = made;
  for (MapEdit edit : other.edits) {
    edit.id += before;
    for (MapEdit::Corner& corner : edit.corners) corner.keyframe += first;
    std::map<int, Pose2> anchors;
    for (const auto& [keyframe, T_keyframe_map] : edit.T_keyframe_map) anchors[keyframe + first] = T_keyframe_map;
    edit.T_keyframe_map = std::move(anchors);
    edit.sigma = turnedSigma(edit.sigma, turn);
    edits.push_back(std::move(edit));
  }
  steps.resize(done);
  for (std::size_t i = 0; i < other.done; ++i)
    steps.push_back({.id = other.steps[i].id + before, .removes = other.steps[i].removes});
  for (const auto& [keyframe, scan] : other.whole) whole[keyframe + first] = scan;
  made += other.made;
  revision += other.revision + 1;
  forgetUndone();
}

Eigen::Vector3d turnedSigma(const Eigen::Vector3d& sigma, double turn) {
  const double c = std::cos(turn), s = std::sin(turn);
  return {std::hypot(c * sigma.x(), s * sigma.y()), std::hypot(s * sigma.x(), c * sigma.y()), sigma.z()};
}

std::vector<int> eraseFrom(KeyframeGraph& keyframes, MapEdits& edits) {
  std::set<int> concerned;
  for (const auto& [id, scan] : edits.whole) concerned.insert(id);
  for (const MapEdit& edit : edits.edits) {
    if (!edit.active) continue;
    for (const auto& [id, T_keyframe_map] : edit.T_keyframe_map) concerned.insert(id);
  }
  std::vector<int> changed;
  for (const int id : concerned) {
    if (id >= keyframes.size()) continue;
    const StoredScan& present = *keyframes.scan(id);
    const auto known = edits.whole.find(id);
    const auto whole = known == edits.whole.end() ? keyframes.scan(id) : known->second;
    auto rest = std::make_shared<StoredScan>(*whole);
    rest->covariance = present.covariance;
    rest->sensitivity = present.sensitivity;
    for (const MapEdit& edit : edits.edits) {
      const auto anchor = edit.T_keyframe_map.find(id);
      if (!edit.active || anchor == edit.T_keyframe_map.end()) continue;
      const PointTransform T_map_keyframe(anchor->second.inverse());
      std::erase_if(rest->points, [&](const Keyframe::Point& point) { return erases(edit, T_map_keyframe, point); });
    }
    if (rest->points.size() < whole->points.size()) {
      edits.whole.insert_or_assign(id, whole);
    } else {
      edits.whole.erase(id);
    }
    if (samePlaces(rest->points, present.points)) continue;
    changed.push_back(id);
    keyframes.setScan(id, std::move(rest));
  }
  return changed;
}

EditedDrawing drawingOf(const MapEdits& edits, const KeyframeGraph& keyframes, std::span<const char> in_map) {
  EditedDrawing drawing;
  for (const MapEdit& edit : edits.edits) {
    if (!edit.active) continue;
    if (edit.kind == EditKind::kErase) drawing.erased.push_back({edit.id, edit.outline, edit.T_keyframe_map});
    if (edit.kind != EditKind::kFree) continue;
    if (Outline outline = pointsOf(edit, keyframes, in_map); !outline.empty())
      drawing.free.push_back(std::move(outline));
  }
  return drawing;
}

double shareLeft(const MapEdit& edit, const KeyframeGraph& keyframes, const Eigen::Vector2d& robot) {
  std::size_t all = 0, left = 0;
  for (const int id : keyframes.near(robot, kEditLimits.around_robot)) {
    const PointTransform T_map_keyframe(keyframes.pose(id));
    const bool concerned = edit.T_keyframe_map.contains(id);
    for (const Keyframe::Point& point : keyframes.scan(id)->points) {
      if ((T_map_keyframe * Eigen::Vector2d(point.x, point.y) - robot).norm() > kEditLimits.around_robot) continue;
      ++all;
      if (!concerned || !erases(edit, T_map_keyframe, point)) ++left;
    }
  }
  return all == 0 ? 1.0 : static_cast<double>(left) / static_cast<double>(all);
}

}  // namespace slam
