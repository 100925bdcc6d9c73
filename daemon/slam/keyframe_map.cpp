// SPDX-License-Identifier: BSD-3-Clause
#include "slam/keyframe_map.hpp"

#include <cmath>

namespace slam {
namespace {

/// Why an erase would leave the robot without what it finds its place by; empty: it does not.
std::string lossBy(const EditRequest& request, const KeyframeMap& map, const Eigen::Vector2d& robot) {
  if (request.kind != EditKind::kErase || request.force || !problemWith(request).empty()) return "";
  const auto edit = anchored(request, map.keyframes, map.in_map);
  const double left = edit ? shareLeft(*edit, map.keyframes, robot) : 1.0;
  if (left >= kEditLimits.least_share) return "";
  return "the robot would get lost: of what it sees around it the map would keep " +
         std::to_string(std::lround(100.0 * left)) + " %; drive it away, erase less, or force it";
}

}  // namespace

std::string KeyframeMap::edit(const EditCommand& command, const Eigen::Vector2d& robot, std::vector<int>* changed,
                              int* concerned) {
  if (command.kind == EditCommand::kAdd) {
    if (std::string words = lossBy(command.request, *this, robot); !words.empty()) return words;
  }
  if (std::string words = edits.carryOut(command, keyframes, in_map, concerned); !words.empty()) return words;
  *changed = eraseFrom(keyframes, edits);
  if (!changed->empty()) reference_cleared = false;
  ++generation;  // also where only the drawing changes: a copy of the grid on its way does not show it
  return "";
}

}  // namespace slam
