// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <string>

#include "slam/map_state.hpp"

namespace slam {

/// How the walls of a map lie: by the normals of the keyframes' points, of which opposite ones count as one.
struct StraightenConfig {
  double bin = 0.0087;   ///< [rad] 0.5 deg of the histogram: wider than the noise of a normal's mean
  double around = 0.05;  ///< [rad] 3 deg about the highest bin: what is averaged, wider than a normal's noise
  double clearly = 1.2;  ///< [1] so much more wall along y than along x turns the map by 90 deg; a square room stays
  double noise = 0.01;   ///< [rad] that walls themselves are off, beside the noise of a normal
  int rounds = 5;        ///< each moves the window onto the mean of what it holds
  std::size_t fewest = 100;  ///< [points] with a normal, below which there is no direction
};

/// [rad] of the dominant walls from map's x axis, in (-pi / 2, pi / 2]; nothing where too few points lie on walls.
std::optional<double> headingOfWalls(const MapState& map, const StraightenConfig& config = {});

/// The same map in another frame: keyframes, edits, views and the robot's pose move along, and the grid is drawn anew.
MapState transformed(const MapState& map, const Pose2& T_new_map, const OccupancyGridConfig& config);

/// T_new_map, in which the dominant walls lie along x. @param origin name of the place that is the new origin; empty:
/// the origin stays
/// @throws std::runtime_error with one sentence where walls or the place are missing
Pose2 straightFrame(const MapState& map, const std::string& origin);

}  // namespace slam
