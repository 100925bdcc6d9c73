// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <vector>

#include "mapping/occupancy_grid.hpp"

namespace slam {

/// A rectangle of a map in the three values of map_server, row by row from the top (largest y) as in an image file.
struct MapImage {
  static constexpr std::uint8_t kOccupied = 0, kFree = 254, kUnknown = 205;
  static constexpr double kOccupiedThreshold = 0.65;  ///< [1] more is occupied
  static constexpr double kFreeThreshold = 0.196;     ///< [1] less is free; with 0.25, value 205 would load as free

  int width = 0, height = 0;              ///< [cells]
  double resolution = 0.05;               ///< [m]
  double origin_x = 0.0, origin_y = 0.0;  ///< [m] lower-left corner of the lower-left cell in map
  std::vector<std::uint8_t> cells;        ///< width * height

  std::uint8_t& at(int column, int row) {
    return cells[static_cast<std::size_t>(height - 1 - row) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>(column)];
  }
  std::uint8_t at(int column, int row) const { return const_cast<MapImage*>(this)->at(column, row); }
};

std::uint8_t classify(double probability);

/// The bounding box of all cells that are not unknown; empty grid: an image of one unknown cell.
MapImage renderMap(const OccupancyGrid& grid);

/// The same map, of an image whose rows run along `yaw` [rad], in one whose rows run along x: turned about its origin.
/// What is occupied stays so, by its cell's middle; what the image does not cover is unknown.
/// @throws std::runtime_error where that has more cells than a picture may have
MapImage alongAxes(const MapImage& image, double yaw);

/// The grid that an image shows: as sure of its cells as a grid can be. The cells lie on the image's own raster: their
/// corners are off by what the image's origin is off from a multiple of the resolution, half a cell at most.
OccupancyGrid toGrid(const MapImage& image);

}  // namespace slam
