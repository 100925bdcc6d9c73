// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/occupancy_grid.hpp"

#include <algorithm>

#include "mapping/ray_traversal.hpp"

namespace slam {

OccupancyGrid::Layer::Layer(LogOdds Cell::*of_cell, const InverseSensorModel& model, Fusion fusion)
    : value(of_cell),
      hit(toLogOdds(model.hit_probability)),
      miss(toLogOdds(model.miss_probability)),
      min(toLogOdds(model.min_probability)),
      max(toLogOdds(model.max_probability)),
      keeps_obstacles(fusion == Fusion::kPaper) {}

OccupancyGrid::OccupancyGrid(const OccupancyGridConfig& config)
    : config_(config),
      inverse_resolution_(1.0 / config.resolution),
      lidar_(&Cell::lidar, config.lidar, config.fusion),
      depth_(&Cell::depth, config.depth, config.fusion) {}

inline void OccupancyGrid::change(CellIndex index, const Layer& layer, LogOdds by) {
  const TileIndex tile = Tiles::tileOf(index);
  if (pen_.index != tile) enter(tile);
  if (pen_.tile == nullptr) return;
  Cell& cell = pen_.tile->at(index.column & (kTileSide - 1), index.row & (kTileSide - 1));
  if (cell.look == look_) return;
  cell.look = look_;
  LogOdds& value = cell.*layer.value;
  // Bayes, eq. 18 of the paper: a sum in log-odds. Clamped, so that it can change again.
  if (value != kCertain) value = static_cast<LogOdds>(std::clamp<int>(value + by, layer.min, layer.max));
  if (layer.keeps_obstacles && value > 0) value = kCertain;
  if (pen_.touched) return;
  pen_.touched = true;
  touched_.push_back(tile);
}

void OccupancyGrid::begin() {
  if (++look_ == 0) ++look_;  // 0 marks a cell that nothing has changed
  hits_.clear();
  rays_.clear();
  touched_.clear();
}

void OccupancyGrid::add(const Pose2& T_map_base, const Pose2& T_base_lidar, std::span<const Keyframe::Point> points) {
  begin();
  const PointTransform T(T_map_base);
  const Eigen::Vector2d lidar = T * T_base_lidar.translation();
  const double max_squared = config_.max_range * config_.max_range;
  const CellIndex start = cellAt(lidar);
  for (const Keyframe::Point& point : points) {
    const Eigen::Vector2d end = T * Eigen::Vector2d(point.x, point.y);
    if ((end - lidar).squaredNorm() > max_squared) continue;
    hits_.push_back(cellAt(end));
    rays_.push_back({start, hits_.back()});
  }
  draw(lidar_);
}

void OccupancyGrid::add(const Pose2& T_map_depth, const DepthView& view) {
  begin();
  const Eigen::Vector2d camera = T_map_depth.translation();
  for (const DepthView::Beam& beam : view.beams) {
    const double direction = T_map_depth.theta + beam.bearing;
    const Eigen::Vector2d ray(std::cos(direction), std::sin(direction));
    const CellIndex end = cellAt(camera + beam.range * ray);
    if (beam.free_from < beam.range) rays_.push_back({cellAt(camera + beam.free_from * ray), end});
    if (beam.hit) hits_.push_back(end);
  }
  for (const DepthView::Surface& surface : view.surfaces) {
    const double direction = T_map_depth.theta + surface.bearing;
    const Eigen::Vector2d ray(std::cos(direction), std::sin(direction));
    const CellIndex last = cellAt(camera + surface.to * ray);
    traverseRay(cellAt(camera + surface.from * ray), last, [this](CellIndex cell) { hits_.push_back(cell); });
    hits_.push_back(last);
  }
  draw(depth_);
}

/// First the hits, then what was seen through, so that a grazing beam does not erase the wall its neighbour hit.
void OccupancyGrid::draw(const Layer& layer) {
  if (hits_.empty() && rays_.empty()) return;
  enter(Tiles::tileOf(hits_.empty() ? rays_.front().from : hits_.front()));
  for (const CellIndex& hit : hits_) change(hit, layer, layer.hit);
  for (const Ray& ray : rays_) {
    traverseRay(ray.from, ray.to, [&](CellIndex cell) { change(cell, layer, layer.miss); });
  }
  for (const TileIndex& tile : touched_) markChanged(tile);
}

void OccupancyGrid::set(CellIndex cell, LogOdds lidar, LogOdds depth) {
  const auto bounded = [](LogOdds value, const Layer& layer) {
    return layer.keeps_obstacles && value > 0 ? kCertain : std::clamp(value, layer.min, layer.max);
  };
  const TileIndex tile = Tiles::tileOf(cell);
  if (pen_.tile == nullptr || pen_.index != tile) enter(tile);
  Cell& written = pen_.tile->at(cell.column & (kTileSide - 1), cell.row & (kTileSide - 1));
  written.lidar = bounded(lidar, lidar_);
  written.depth = bounded(depth, depth_);
}

void OccupancyGrid::keepFree(TileIndex tile, const std::bitset<kTileSide * kTileSide>& cells) {
  Tiles::Tile* const known = tiles_.find(tile);
  if (known == nullptr) return;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Cell& cell = known->cells[i];
    if (!cells.test(i) || !cell.seen()) continue;
    cell.lidar = lidar_.min;
    cell.depth = std::min<LogOdds>(cell.depth, 0);
  }
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
  pen_ = {};
  patch.tiles_.takeTiles([&](TileIndex tile, std::unique_ptr<Tiles::Tile> content) {
    for (Cell& cell : content->cells) cell.look = cell.seen() ? look_ : 0;  // serials of the patch mean nothing here
    tiles_.put(tile, std::move(content));
    markChanged(tile);
  });
}

OccupancyGrid OccupancyGrid::clone() const {
  OccupancyGrid copy(config_);
  copy.tiles_ = tiles_.clone();
  copy.look_ = look_;
  return copy;
}

std::vector<TileIndex> OccupancyGrid::takeChangedTiles() { return std::exchange(changed_, {}); }

}  // namespace slam
