// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <vector>

#include "posegraph/wall_field.hpp"

namespace slam {

struct WallContinuationConfig {
  double length = 10.0;   ///< [m] that a wall is followed beyond its end
  double straight = 2.0;  ///< [m] of straight wall before its end tell where it would go on
  double gap = 3.0;       ///< [m] from its end to the map's rim at most: walls seen at a grazing angle are drawn late
};

/// Where the straight walls of a map would go on beyond its rim: a corridor does not end where the robot that mapped it
/// turned round. A wall ends at the rim when the map knows nothing beside its further way; one that ends at free space
/// or at another wall ends there.
/// @return cells of which the map knows nothing, as thick as its walls, each once
std::vector<std::size_t> continuedWalls(const WallField& walls, const WallContinuationConfig& config = {});

}  // namespace slam
