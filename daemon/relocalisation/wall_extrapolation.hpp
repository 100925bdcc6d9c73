// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <vector>

#include "relocalisation/distance_field.hpp"

namespace slam {

struct WallExtrapolationConfig {
  double length = 10.0;    ///< [m] that a wall is followed beyond its end
  double straight = 2.0;   ///< [m] of straight wall before its end tell where it would go on
  double gap = 3.0;        ///< [m] from its end to the map's rim at most: walls seen at a grazing angle are drawn late
  double spread = 0.08;    ///< [m] of a straight wall's points, standard deviation
  double share = 0.7;      ///< [1] of a straight wall that is there
  double same_face = 0.5;  ///< cosine of two normals of one face
  double beside = 0.5;     ///< [m] from the wall, where the map ends or does not
  double end = 0.3;        ///< [m] beyond the last point of a wall without a wall
};

/// Where the straight walls of a map would go on beyond its rim: a corridor does not end where the robot that mapped it
/// turned round. A wall ends at the rim when the map knows nothing beside its further way; one that ends at free space
/// or at another wall ends there.
/// @return cells of which the map knows nothing, as thick as its walls, each once
std::vector<std::size_t> extrapolatedWalls(const DistanceField& walls, const WallExtrapolationConfig& config = {});

}  // namespace slam
