// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/truth_map.hpp"

#include <cmath>

#include "mapping/ray_traversal.hpp"

namespace slam::sim {

TruthMap::TruthMap(const World& world, double bottom, double top, double resolution)
    : world_(world), bottom_(bottom), top_(top) {
  const Bounds bounds = world.bounds();
  const auto cells = [&](double metres) { return static_cast<int>(std::floor(metres / resolution)); };
  image_.resolution = resolution;
  const int left = cells(bounds.low.x()) - 1, low = cells(bounds.low.y()) - 1;
  image_.width = cells(bounds.high.x()) + 2 - left;
  image_.height = cells(bounds.high.y()) + 2 - low;
  image_.origin_x = left * resolution;
  image_.origin_y = low * resolution;
  image_.cells.assign(static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height),
                      MapImage::kUnknown);
}

void TruthMap::see(const Eigen::Vector2d& from, double direction, double range) {
  if (!std::isfinite(range)) return;  // just past an edge
  const auto cell = [&](const Eigen::Vector2d& p) {
    return CellIndex{static_cast<int>(std::floor((p.x() - image_.origin_x) / image_.resolution)),
                     static_cast<int>(std::floor((p.y() - image_.origin_y) / image_.resolution))};
  };
  // One cell deeper than the surface: a cell that the surface only touches counts as looked at.
  const Eigen::Vector2d ray(std::cos(direction), std::sin(direction));
  traverseRay(cell(from), cell(from + (range + image_.resolution) * ray), [this](CellIndex c) {
    if (c.column < 0 || c.row < 0 || c.column >= image_.width || c.row >= image_.height) return;
    image_.at(c.column, c.row) = MapImage::kFree;
  });
}

MapImage TruthMap::image() const {
  MapImage image = image_;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      std::uint8_t& cell = image.at(column, row);
      if (cell == MapImage::kUnknown) continue;
      const Eigen::Vector2d centre(image.origin_x + (column + 0.5) * image.resolution,
                                   image.origin_y + (row + 0.5) * image.resolution);
      if (world_.occupied(centre, bottom_, top_, image.resolution / 2)) cell = MapImage::kOccupied;
    }
  }
  return image;
}

}  // namespace slam::sim
