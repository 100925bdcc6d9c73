// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/truth_map.hpp"

#include <cmath>

#include "mapping/ray_traversal.hpp"

namespace slam::sim {
namespace {

CellIndex cellAt(const MapImage& image, const Eigen::Vector2d& p) {
  return {static_cast<int>(std::floor((p.x() - image.origin_x) / image.resolution)),
          static_cast<int>(std::floor((p.y() - image.origin_y) / image.resolution))};
}

bool contains(const MapImage& image, CellIndex c) {
  return c.column >= 0 && c.row >= 0 && c.column < image.width && c.row < image.height;
}

}  // namespace

TruthMap::TruthMap(const World& world, const HeightBand& band, const HeightBand& scanned, double resolution)
    : world_(world), band_(band), scanned_(scanned) {
  const Bounds bounds = world.bounds();
  const auto cells = [&](double metres) { return static_cast<int>(std::floor(metres / resolution)); };
  seen_.resolution = resolution;
  const int left = cells(bounds.low.x()) - 1, low = cells(bounds.low.y()) - 1;
  seen_.width = cells(bounds.high.x()) + 2 - left;
  seen_.height = cells(bounds.high.y()) + 2 - low;
  seen_.origin_x = left * resolution;
  seen_.origin_y = low * resolution;
  seen_.cells.assign(static_cast<std::size_t>(seen_.width) * static_cast<std::size_t>(seen_.height), 0);
}

void TruthMap::mark(const Eigen::Vector2d& p, std::uint8_t what) {
  const CellIndex c = cellAt(seen_, p);
  if (contains(seen_, c)) seen_.at(c.column, c.row) |= what;
}

void TruthMap::seeRay(const Eigen::Vector2d& from, double direction, double range) {
  if (!std::isfinite(range)) return;  // just past an edge
  // One cell deeper than the surface: a cell that the surface only touches counts as looked at.
  const Eigen::Vector2d ray(std::cos(direction), std::sin(direction));
  traverseRay(cellAt(seen_, from), cellAt(seen_, from + (range + seen_.resolution) * ray), [this](CellIndex c) {
    if (contains(seen_, c)) seen_.at(c.column, c.row) |= kPassed;
  });
  seeSurface(from + range * ray, ray);
}

void TruthMap::seeSurface(const Eigen::Vector2d& p, const Eigen::Vector2d& direction) {
  mark(p, kMet);
  mark(p + 0.5 * seen_.resolution * direction.normalized(), kMet);
}

void TruthMap::seeFloor(const Eigen::Vector2d& p) { mark(p, kPassed); }

MapImage TruthMap::image() const {
  MapImage image = seen_;
  const double margin = image.resolution / 2;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const std::uint8_t seen = seen_.at(column, row);
      std::uint8_t& cell = image.at(column, row);
      cell = MapImage::kUnknown;
      if (seen == 0) continue;
      const Eigen::Vector2d centre(image.origin_x + (column + 0.5) * image.resolution,
                                   image.origin_y + (row + 0.5) * image.resolution);
      if (!world_.occupied(centre, band_.bottom, band_.top, margin)) {
        if (seen & kPassed) cell = MapImage::kFree;
      } else if ((seen & kMet) || world_.occupied(centre, scanned_.bottom, scanned_.top, margin)) {
        cell = MapImage::kOccupied;
      }
    }
  }
  return image;
}

}  // namespace slam::sim
