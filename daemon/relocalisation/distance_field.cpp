// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/distance_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace slam {
namespace {

template <typename Visit>
void forEachWall(const KeyframeGraph& keyframes, std::span<const int> map, Visit&& visit) {
  for (const int id : map) {
    const Pose2& T_map_id = keyframes.pose(id);
    for (const Keyframe::Point& point : keyframes.scan(id)->points) visit(T_map_id * Eigen::Vector2d(point.x, point.y));
  }
}

}  // namespace

void forEachWallPoint(const KeyframeGraph& keyframes, std::span<const int> map,
                      const std::function<void(const Eigen::Vector2d&)>& visit) {
  for (const int id : map) {
    for (const Eigen::Vector2f& p : keyframes.scan(id)->solid) visit(keyframes.pose(id) * p.cast<double>());
  }
  forEachWall(keyframes, map, visit);
}

DistanceField::DistanceField(const KeyframeGraph& keyframes, std::span<const int> map,
                             const DistanceFieldConfig& config)
    : config_(config) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  forEachWall(keyframes, map, [&](const Eigen::Vector2d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  });
  if (!low.allFinite()) return;
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
  collect(keyframes, map);
  spread();
  mark(keyframes, map);
  measure();
}

/// Of the walls in a cell the one nearest to its middle, for scans show a wall again and again: kept in nearest_. Of a
/// floor plan all.
void DistanceField::collect(const KeyframeGraph& keyframes, std::span<const int> map) {
  ScanPoints points;
  for (const int id : map) {
    keyframes.points(id, points);
    const Pose2& T_map_id = keyframes.pose(id);
    const Pose2 turn{0.0, 0.0, T_map_id.theta};
    for (const ScanPoint& point : points) {
      const Wall wall{T_map_id * point.position, turn * point.normal};
      const Eigen::Vector2d at = (wall.position - origin_) / cell_;
      const int column = static_cast<int>(at.x()), row = static_cast<int>(at.y());
      std::int32_t& kept = nearest_[index(column, row)];
      const bool nearer = kept < 0 || distance(column, row, wall) < distance(column, row, wallAt(kept));
      if (kept >= 0 && config_.kind == MapKind::kScans) {
        if (nearer) walls_[static_cast<std::size_t>(kept)] = wall;
        continue;
      }
      if (nearer) kept = static_cast<std::int32_t>(walls_.size());
      walls_.push_back(wall);
    }
  }
}

double DistanceField::distance(int column, int row, const Wall& wall) const {
  return (wall.position - origin_ - cell_ * Eigen::Vector2d(column + 0.5, row + 0.5)).norm();
}

/// Each cell gets its nearest wall from its neighbours, nearest cells first.
void DistanceField::spread() {
  struct Front {
    float distance;
    int column, row;
    std::int32_t wall;
    bool operator<(const Front& other) const { return distance > other.distance; }
  };
  std::vector<float> least(nearest_.size(), static_cast<float>(config_.reach));  // [m] of what waits in the front
  std::priority_queue<Front> front;
  const auto push = [&](int column, int row, std::int32_t wall) {
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
    const auto away = static_cast<float>(distance(column, row, wallAt(wall)));
    float& shortest = least[index(column, row)];
    if (away >= shortest) return;
    shortest = away;
    front.push({away, column, row, wall});
  };
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      if (const std::int32_t wall = std::exchange(nearest_[index(column, row)], -1); wall >= 0) push(column, row, wall);
    }
  }
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
    for (const Eigen::Vector2f& p : scan.solid) mark(T_map_id * p.cast<double>(), Known::kSolid);
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
  return wall < 0 ? nullptr : &wallAt(wall);
}

}  // namespace slam
