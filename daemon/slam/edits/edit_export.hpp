// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "mapping/map_image.hpp"
#include "slam/map_state.hpp"

namespace slam {

/// Where the robot shall not go, as a picture of the same cells as a picture of the map: occupied in no-go zones and on
/// walls, free elsewhere. Programs with map_server's format take it as a mask.
MapImage keepOutMask(const MapState& map, const MapImage& image);
/// The edits of a map in effect as GeoJSON: a feature for each, in metres of the map, which is no place on earth.
std::string editsGeoJson(const MapState& map);

}  // namespace slam
