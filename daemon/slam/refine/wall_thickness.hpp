// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>

#include "graph/keyframe_graph.hpp"

namespace slam {

struct WallThicknessConfig {
  double cell = 0.2;   ///< [m] a side: walls in it are straight
  int directions = 8;  ///< of normals: the faces of a thin wall are two walls
  int fewest = 10;     ///< points in a cell that make a wall of it
};

/// [m] RMS of the points' distances from the middle of the wall that they are on, over all walls of a map: what poses
/// that contradict each other make thick. 0 where there is no wall.
double wallThickness(const KeyframeGraph& keyframes, std::span<const char> in_map,
                     const WallThicknessConfig& config = {});

}  // namespace slam
