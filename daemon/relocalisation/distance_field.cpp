// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/distance_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace slam {
DistanceField::DistanceField(const KeyframeGraph& keyframes, std::span<const int> map,
                             const DistanceFieldConfig& config)
    : config_(config) {
  collect(keyframes, map);
  if (walls_.empty()) return;
  Eigen::Vector2d low = walls_.front().position, high = low;
  for (const Wall& wall : walls_) {
    low = low.cwiseMin(wall.position);
    high = high.cwiseMax(wall.position);
  }
  low.array() -= config.reach + config.margin;
  high.array() += config.reach + config.margin;
  const Eigen::Vector2d size = high - low;
  cell_ = std::max(config.cell, std::sqrt(size.x() * size.y() / config.max_cells));
  origin_ =
      low - Eigen::Vector2d::Constant(0.5 * cell_);  // a floor plan's walls and free cells then lie amid our cells
  columns_ = static_cast<int>(std::ceil(size.x() / cell_)) + 1;
  rows_ = static_cast<int>(std::ceil(size.y() / cell_)) + 1;
  const auto cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  nearest_.assign(cells, -1);
  known_.assign(cells, Known::kNothing);
  spread();
  mark(keyframes, map);
  measure();
}

void DistanceField::collect(const KeyframeGraph& keyframes, std::span<const int> map) {
  std::size_t count = 0;
  for (const int id : map) count += keyframes.scan(id)->points.size();
  walls_.reserve(count);  // of a large map most of the memory
  ScanPoints points;
  for (const int id : map) {
    keyframes.points(id, points);
    const Pose2& T_map_id = keyframes.pose(id);
    const Pose2 turn{0.0, 0.0, T_map_id.theta};
    for (const ScanPoint& point : points) walls_.push_back({T_map_id * point.position, turn * point.normal});
  }
}

/// Each cell learns its nearest wall from its neighbours, nearest cells first.
void DistanceField::spread() {
  struct Front {
    float distance;
    int column, row;
    std::int32_t wall;
    bool operator<(const Front& other) const { return distance > other.distance; }
  };
  std::priority_queue<Front> front;
  const auto distance = [&](int column, int row, std::int32_t wall) {
    const Eigen::Vector2d centre = origin_ + cell_ * Eigen::Vector2d(column + 0.5, row + 0.5);
    return (walls_[static_cast<std::size_t>(wall)].position - centre).norm();
  };
  const auto push = [&](int column, int row, std::int32_t wall) {
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
    if (nearest_[index(column, row)] >= 0) return;
    const double away = distance(column, row, wall);
    if (away <= config_.reach) front.push({static_cast<float>(away), column, row, wall});
  };
  // Of the walls in a cell, only that nearest to its middle spreads: maps hold many scans of a wall.
  std::vector<float> least(nearest_.size(), std::numeric_limits<float>::infinity());  // [m]
  const auto forEachWall = [&](auto&& visit) {
    for (std::size_t i = 0; i < walls_.size(); ++i) {
      const Eigen::Vector2d at = (walls_[i].position - origin_) / cell_;
      const int column = static_cast<int>(at.x()), row = static_cast<int>(at.y());
      const auto wall = static_cast<std::int32_t>(i);
      visit(column, row, wall, static_cast<float>(distance(column, row, wall)), least[index(column, row)]);
    }
  };
  forEachWall([&](int, int, std::int32_t, float away, float& shortest) { shortest = std::min(shortest, away); });
  forEachWall([&](int column, int row, std::int32_t wall, float away, const float& shortest) {
    if (away <= shortest) push(column, row, wall);
  });
  while (!front.empty()) {
    const Front next = front.top();
    front.pop();
    std::int32_t& wall = nearest_[index(next.column, next.row)];
    if (wall >= 0) continue;
    wall = next.wall;
    for (int r = -1; r <= 1; ++r) {
      for (int c = -1; c <= 1; ++c) push(next.column + c, next.row + r, next.wall);
    }
  }
}

void DistanceField::mark(const KeyframeGraph& keyframes, std::span<const int> map) {
  const auto mark = [&](const Eigen::Vector2d& p, Known what) {
    if (const auto i = index(p); i >= 0) known_[static_cast<std::size_t>(i)] = what;
  };
  for (const int id : map) {
    const StoredScan& scan = *keyframes.scan(id);
    const Pose2& T_map_id = keyframes.pose(id);
    for (const Eigen::Vector2f& p : scan.free) mark(T_map_id * p.cast<double>(), Known::kFree);
    for (const Eigen::Vector2f& p : scan.solid) {
      solid_.push_back(T_map_id * p.cast<double>());
      mark(solid_.back(), Known::kSolid);
    }
    if (config_.kind == MapKind::kFloorPlan) continue;
    const PointTransform T(T_map_id);
    const auto toCells = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d { return (T * p - origin_) / cell_; };
    const Eigen::Vector2d lidar = toCells(scan.T_base_lidar.translation());
    const bool inside = cellAt(lidar) >= 0;  // as all walls are, and so all ways to them
    for (const Keyframe::Point& point : scan.points) {
      const Eigen::Vector2d ray = toCells(Eigen::Vector2d(point.x, point.y)) - lidar;
      const double length = ray.norm(), end = length - config_.before_end / cell_;
      const Eigen::Vector2d step = ray / length;
      for (double s = 0.0; s < end; s += 1.0) {
        const Eigen::Vector2d at = lidar + s * step;
        if (inside || cellAt(at) >= 0) known_[index(static_cast<int>(at.x()), static_cast<int>(at.y()))] = Known::kFree;
      }
    }
  }
  for (const Wall& wall : walls_) mark(wall.position, Known::kSolid);
}

/// A wall has two faces, each as long as the wall.
void DistanceField::measure() {
  const auto solid = [&](int column, int row) { return known_[index(column, row)] == Known::kSolid; };
  std::int64_t cells = 0, faces = 0;
  for (int row = 0; row + 1 < rows_; ++row) {
    for (int column = 0; column + 1 < columns_; ++column) {
      cells += solid(column, row);
      faces += (solid(column, row) != solid(column + 1, row)) + (solid(column, row) != solid(column, row + 1));
    }
  }
  if (cells > 0) thickness_ = cell_ * std::max(1.0, 2.0 * static_cast<double>(cells) / static_cast<double>(faces));
}

std::vector<Eigen::Vector2d> DistanceField::wallPoints() const {
  std::vector<Eigen::Vector2d> points;
  points.reserve(solid_.size() + walls_.size());
  points.insert(points.end(), solid_.begin(), solid_.end());
  for (const Wall& wall : walls_) points.push_back(wall.position);
  return points;
}

std::int64_t DistanceField::index(const Eigen::Vector2d& p_map) const { return cellAt((p_map - origin_) / cell_); }

std::int64_t DistanceField::cellAt(const Eigen::Vector2d& at) const {
  if (!(at.x() >= 0.0 && at.y() >= 0.0 && at.x() < columns_ && at.y() < rows_)) return -1;
  return static_cast<std::int64_t>(at.y()) * columns_ + static_cast<std::int64_t>(at.x());
}

DistanceField::Known DistanceField::known(int column, int row) const {
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return Known::kNothing;
  return known_[index(column, row)];
}

const DistanceField::Wall* DistanceField::nearest(const Eigen::Vector2d& p_map) const {
  const auto i = index(p_map);
  if (i < 0) return nullptr;
  const std::int32_t wall = nearest_[static_cast<std::size_t>(i)];
  return wall < 0 ? nullptr : &walls_[static_cast<std::size_t>(wall)];
}

}  // namespace slam
