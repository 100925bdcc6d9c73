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

inline void OccupancyGrid::change(CellIndex index, LogOdds by) {
  const TileIndex tile = Tiles::tileOf(index);
  if (pen_.index != tile) enter(tile);
  if (pen_.tile == nullptr) return;
  Cell& cell = pen_.tile->at(index.column & (kTileSide - 1), index.row & (kTileSide - 1));
  if (cell.scan == scan_) return;
  cell.scan = scan_;
  cell.log_odds = static_cast<LogOdds>(std::clamp<int>(cell.log_odds + by, min_, max_));
  if (pen_.touched) return;
  pen_.touched = true;
  touched_.push_back(tile);
}

void OccupancyGrid::add(const Pose2& T_map_base, const Pose2& T_base_lidar, std::span<const Keyframe::Point> points) {
  if (++scan_ == 0) ++scan_;  // 0 marks a cell that no scan has changed
  const Eigen::Vector2d lidar = T_map_base * T_base_lidar.translation();
  const double max_squared = config_.max_range * config_.max_range;
  ends_.clear();
  touched_.clear();
  for (const Keyframe::Point& point : points) {
    const Eigen::Vector2d end = T_map_base * Eigen::Vector2d(point.x, point.y);
    if ((end - lidar).squaredNorm() <= max_squared) ends_.push_back(cellAt(end));
  }
  if (ends_.empty()) return;
  const CellIndex start = cellAt(lidar);
  enter(Tiles::tileOf(start));
  for (const CellIndex& end : ends_) change(end, hit_);
  for (const CellIndex& end : ends_) {
    traverseRay(start, end, [this](CellIndex cell) { change(cell, miss_); });
  }
  for (const TileIndex& tile : touched_) markChanged(tile);
}

void OccupancyGrid::set(CellIndex cell, LogOdds log_odds) {
  tiles_.cell(cell).log_odds = std::clamp(log_odds, min_, max_);
}

void OccupancyGrid::enter(TileIndex tile) {
  pen_.index = tile;
  pen_.tile = grows_ ? &tiles_.make(tile) : tiles_.find(tile);
  pen_.touched = std::find(touched_.begin(), touched_.end(), tile) != touched_.end();
}

void OccupancyGrid::markChanged(TileIndex tile) {
  if (std::find(changed_.begin(), changed_.end(), tile) == changed_.end()) changed_.push_back(tile);
}

OccupancyGrid OccupancyGrid::patch(const OccupancyGridConfig& config, std::span<const TileIndex> tiles) {
  OccupancyGrid patch(config);
  patch.grows_ = false;
  for (const TileIndex& tile : tiles) patch.tiles_.make(tile);
  return patch;
}

void OccupancyGrid::replaceBy(OccupancyGrid&& patch) {
  std::vector<TileIndex> tiles;
  patch.tiles_.forEachTile([&](TileIndex tile, const auto&) { tiles.push_back(tile); });
  for (const TileIndex& tile : tiles) {
    auto content = patch.tiles_.take(tile);
    for (Cell& cell : content->cells) cell.scan = 0;  // serials of the patch mean nothing here
    tiles_.put(tile, std::move(content));
    markChanged(tile);
  }
}

OccupancyGrid OccupancyGrid::clone() const {
  OccupancyGrid copy(config_);
  copy.tiles_ = tiles_.clone();
  copy.scan_ = scan_;
  return copy;
}

std::vector<TileIndex> OccupancyGrid::takeChangedTiles() { return std::exchange(changed_, {}); }

}  // namespace slam
