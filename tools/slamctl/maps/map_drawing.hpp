// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <span>
#include <string>

#include "mapping/map_image.hpp"
#include "slam/map_state.hpp"

namespace slam {

/// A map as a drawing in millimetres of paper at 1:100: walls, path, and what was drawn into it with its names.
/// @param path [m] positions in map
std::string mapSvg(const MapState& map, const MapImage& image, std::span<const Eigen::Vector2d> path);

/// All points that the keyframes of a map saw, in map [m], z 0: PLY, binary, little-endian.
std::string pointsPly(const MapState& map);

}  // namespace slam
