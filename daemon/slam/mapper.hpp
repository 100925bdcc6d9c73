// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "core/keyframe.hpp"
#include "mapping/occupancy_grid.hpp"

namespace slam {

/// Back end: draws keyframes into the map. Not safe for concurrent use.
class Mapper {
 public:
  explicit Mapper(const OccupancyGridConfig& config = {}) : config_(config), grid_(config) {}

  void add(const Keyframe& keyframe);
  /// Forgets the map.
  void reset();

  const OccupancyGrid& grid() const { return grid_; }
  std::vector<TileIndex> takeChangedTiles() { return grid_.takeChangedTiles(); }
  /// [m] positions of the keyframes in map
  const std::vector<Eigen::Vector2d>& path() const { return path_; }

 private:
  OccupancyGridConfig config_;
  OccupancyGrid grid_;
  std::vector<Eigen::Vector2d> path_;
};

}  // namespace slam
