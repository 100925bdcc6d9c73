// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "mapping/occupancy_grid.hpp"

namespace slam {

/// `slamctl export`: what is written of a stored map.
struct MapExport {
  std::filesystem::path map;     ///< folder of it
  std::filesystem::path prefix;  ///< of the files to write
  OccupancyGridConfig grid = {};
  bool zones = false;  ///< the keep-out mask and .geojson also where nothing is drawn into it

  /// Writes map_server's pair, a PNG, and what was drawn into the map. @param remarks out: what of the map is damaged
  /// @return what was written, a line each @throws std::runtime_error with the reason why not
  std::vector<std::string> write(std::vector<std::string>* remarks) const;
  /// Writes all of it as PREFIX.zip: also an SVG, a PLY of all points and a TUM of the path, by the keyframes. As
  /// write()
  std::vector<std::string> writeAll(std::vector<std::string>* remarks) const;
};

}  // namespace slam
