// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/map_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/plausibility.hpp"

namespace slam {

std::uint8_t classify(double probability) {
  if (probability > MapImage::kOccupiedThreshold) return MapImage::kOccupied;
  return probability < MapImage::kFreeThreshold ? MapImage::kFree : MapImage::kUnknown;
}

MapImage renderMap(const OccupancyGrid& grid) {
  constexpr int kSide = OccupancyGrid::kTileSide;
  CellIndex low{std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};
  CellIndex high{std::numeric_limits<int>::min(), std::numeric_limits<int>::min()};
  const auto forEachCell = [&](auto&& visit) {
    grid.tiles().forEachTile([&](TileIndex tile, const OccupancyGrid::Tiles::Tile& data) {
      for (int row = 0; row < kSide; ++row) {
        for (int column = 0; column < kSide; ++column) {
          const std::uint8_t value = classify(toProbability(grid.fused(data.at(column, row))));
          if (value == MapImage::kUnknown) continue;
          visit(CellIndex{tile.column * kSide + column, tile.row * kSide + row}, value);
        }
      }
    });
  };
  forEachCell([&](CellIndex cell, std::uint8_t) {
    low = {std::min(low.column, cell.column), std::min(low.row, cell.row)};
    high = {std::max(high.column, cell.column), std::max(high.row, cell.row)};
  });
  if (low.column > high.column) low = high = {0, 0};

  MapImage image;
  image.width = high.column - low.column + 1;
  image.height = high.row - low.row + 1;
  image.resolution = grid.resolution();
  image.origin_x = low.column * grid.resolution();
  image.origin_y = low.row * grid.resolution();
  if (const std::string words = implausibilityOfSize(image.width, image.height); !words.empty())
    throw std::runtime_error("the map is too large for a picture: " + words +
                             "; the map itself stays as it is; draw parts that lie far apart as maps of their own");
  image.cells.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height),
                     MapImage::kUnknown);
  forEachCell(
      [&](CellIndex cell, std::uint8_t value) { image.at(cell.column - low.column, cell.row - low.row) = value; });
  return image;
}

OccupancyGrid toGrid(const MapImage& image) {
  OccupancyGridConfig config;
  config.resolution = image.resolution;
  OccupancyGrid grid(config);
  const int left = static_cast<int>(std::lround(image.origin_x / image.resolution));
  const int bottom = static_cast<int>(std::lround(image.origin_y / image.resolution));
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const std::uint8_t value = image.at(column, row);
      if (value == MapImage::kUnknown) continue;
      const double probability =
          value == MapImage::kOccupied ? config.lidar.max_probability : config.lidar.min_probability;
      grid.set({left + column, bottom + row}, toLogOdds(probability));
    }
  }
  return grid;
}

}  // namespace slam
