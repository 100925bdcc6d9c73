// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/occupancy_grid.hpp"

#include <algorithm>

#include "mapping/ray_traversal.hpp"

namespace slam {

OccupancyGrid::OccupancyGrid(const OccupancyGridConfig& config)
    : config_(config),
      inverse_resolution_(1.0 / config.resolution),
      hit_(toLogOdds(config.lidar.hit_probability)),
      miss_(toLogOdds(config.lidar.miss_probability)),
      min_(toLogOdds(config.lidar.min_probability)),
      max_(toLogOdds(config.lidar.max_probability)) {}

void OccupancyGrid::add(const Keyframe& keyframe) {
  if (++scan_ == 0) ++scan_;  // 0 marks a cell that no scan has changed
  const Eigen::Vector2d lidar = keyframe.T_map_base * keyframe.T_base_lidar.translation();
  const double max_squared = config_.max_range * config_.max_range;
  ends_.clear();
  for (const Keyframe::Point& point : keyframe.points()) {
    const Eigen::Vector2d end = keyframe.T_map_base * Eigen::Vector2d(point.x, point.y);
    if ((end - lidar).squaredNorm() <= max_squared) ends_.push_back(cellAt(end));
  }
  for (const CellIndex& end : ends_) change(end, hit_);
  const CellIndex start = cellAt(lidar);
  for (const CellIndex& end : ends_) {
    traverseRay(start, end, [this](CellIndex cell) { change(cell, miss_); });
  }
}

void OccupancyGrid::change(CellIndex index, LogOdds by) {
  const TileIndex tile = Tiles::tileOf(index);
  Cell& cell = tiles_.cell(index);
  if (cell.scan == scan_) return;
  cell.scan = scan_;
  cell.log_odds = static_cast<LogOdds>(std::clamp<int>(cell.log_odds + by, min_, max_));
  if (changed_.empty() ||
      (changed_.back() != tile && std::find(changed_.begin(), changed_.end(), tile) == changed_.end())) {
    changed_.push_back(tile);
  }
}

std::vector<TileIndex> OccupancyGrid::takeChangedTiles() { return std::exchange(changed_, {}); }

}  // namespace slam
