// SPDX-License-Identifier: BSD-3-Clause
#include "slam/keyframe_map.hpp"

#include "problems/answers.hpp"

namespace slam {
namespace {

/// Why an erase would leave the robot without what it finds its place by; none: it does not.
Problem lossBy(const EditRequest& request, const KeyframeMap& map, const Eigen::Vector2d& robot) {
  if (request.kind != EditKind::kErase || request.force || problemWith(request)) return {};
  const auto edit = anchored(request, map.keyframes, map.in_map);
  const double left = edit ? shareLeft(*edit, map.keyframes, robot) : 1.0;
  if (left >= kEditLimits.least_share) return {};
  return {answer::kRobotLost, {100.0 * left}};
}

}  // namespace

Problem KeyframeMap::edit(const EditCommand& command, const Eigen::Vector2d& robot, std::vector<int>* changed,
                          int* concerned) {
  if (command.kind == EditCommand::kAdd) {
    if (const Problem problem = lossBy(command.request, *this, robot)) return problem;
  }
  if (const Problem problem = edits.carryOut(command, keyframes, in_map, concerned)) return problem;
  *changed = eraseFrom(keyframes, edits);
  if (!changed->empty()) reference_cleared = false;
  ++generation;  // also where only the drawing changes: a copy of the grid on its way does not show it
  return {};
}

}  // namespace slam
