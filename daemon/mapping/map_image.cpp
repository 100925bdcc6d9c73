// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/map_image.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/plausibility.hpp"
#include "core/pose2.hpp"

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

MapImage alongAxes(const MapImage& image, double yaw) {
  const PointTransform T_axes_image({0.0, 0.0, yaw}), T_image_axes({0.0, 0.0, -yaw});  // [cells], about the origin
  Eigen::AlignedBox2d box;
  for (const double x : {0, image.width})
    for (const double y : {0, image.height}) box.extend(T_axes_image * Eigen::Vector2d(x, y));
  // What is less than a tenth of a cell beyond the last row or column, is rounding of the yaw.
  const Eigen::Vector2d corner = box.min(), size = (box.sizes().array() - 0.1).ceil();
  MapImage turned = image;
  turned.width = static_cast<int>(size.x());
  turned.height = static_cast<int>(size.y());
  turned.origin_x += corner.x() * image.resolution;
  turned.origin_y += corner.y() * image.resolution;
  if (const std::string words = implausibilityOfSize(turned.width, turned.height); !words.empty())
    throw std::runtime_error("turned by its yaw, " + words + "; the map is not read; turn the picture and set it to 0");
  turned.cells.assign(static_cast<std::size_t>(turned.width) * static_cast<std::size_t>(turned.height),
                      MapImage::kUnknown);
  const auto at = [](MapImage& of, const Eigen::Vector2d& p) -> std::uint8_t* {
    const double column = std::floor(p.x()), row = std::floor(p.y());
    const bool inside = column >= 0.0 && row >= 0.0 && column < of.width && row < of.height;
    return inside ? &of.at(static_cast<int>(column), static_cast<int>(row)) : nullptr;
  };
  const auto middle = [](int column, int row) { return Eigen::Vector2d(column + 0.5, row + 0.5); };
  for (int row = 0; row < turned.height; ++row) {
    for (int column = 0; column < turned.width; ++column) {
      const std::uint8_t* cell = at(const_cast<MapImage&>(image), T_image_axes * (corner + middle(column, row)));
      if (cell != nullptr) turned.at(column, row) = *cell;
    }
  }
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      if (image.at(column, row) != MapImage::kOccupied) continue;
      std::uint8_t* cell = at(turned, T_axes_image * middle(column, row) - corner);
      if (cell != nullptr) *cell = MapImage::kOccupied;
    }
  }
  return turned;
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
