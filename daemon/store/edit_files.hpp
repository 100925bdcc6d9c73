// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>

#include "mapping/map_image.hpp"
#include "slam/map_state.hpp"

namespace slam {

/// Writes PREFIX.geojson and PREFIX-keepout.yaml and .pgm beside a map's files, where the map has edits.
/// @param image of the map @param always also where it has none @return whether they are written
/// @throws std::runtime_error with file and reason
bool writeEditFiles(const std::filesystem::path& prefix, const MapState& map, const MapImage& image,
                    bool always = false);

}  // namespace slam
