// SPDX-License-Identifier: BSD-3-Clause
#include "slam/refine/wall_thickness.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>

namespace slam {
namespace {

/// Points of one wall in a cell.
struct Wall {
  double points = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();      // [m] from the cell's corner
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();  // [m^2]

  void add(const Eigen::Vector2d& p) {
    ++points;
    sum += p;
    squares += p * p.transpose();
  }
  /// [m^2] sum of squared distances from the line through them
  double across() const {
    const Eigen::Matrix2d spread = squares - sum * sum.transpose() / points;
    return std::max(0.0,
                    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread, Eigen::EigenvaluesOnly).eigenvalues()[0]);
  }
};

}  // namespace

double wallThickness(const KeyframeGraph& keyframes, std::span<const char> in_map, const WallThicknessConfig& config) {
  const auto cellOf = [](double column, double row, double direction) {  // in 28, 28 and 8 bits
    const auto cut = [](double number) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(number)) & ((1ULL << 28) - 1);
    };
    return cut(column) << 36 | cut(row) << 8 | static_cast<std::uint64_t>(direction);
  };
  std::unordered_map<std::uint64_t, Wall> walls;
  for (int id = 0; id < keyframes.size(); ++id) {
    if (in_map[static_cast<std::size_t>(id)] == 0) continue;
    const Pose2& T_map_base = keyframes.pose(id);
    const PointTransform transform(T_map_base);
    for (const Keyframe::Point& point : keyframes.scan(id)->points) {
      if (point.normal == Keyframe::Point::kNoNormal) continue;
      const Eigen::Vector2d p = (transform * Eigen::Vector2d(point.x, point.y)) / config.cell;
      const Eigen::Vector2d corner(std::floor(p.x()), std::floor(p.y()));
      const double turn = (T_map_base.theta + point.normal * Keyframe::Point::kAngle) / (2.0 * std::numbers::pi);
      const double direction = std::floor((turn - std::floor(turn)) * config.directions);
      walls[cellOf(corner.x(), corner.y(), direction)].add(config.cell * (p - corner));
    }
  }
  double squares = 0.0, points = 0.0;
  for (const auto& [key, wall] : walls) {
    if (wall.points < config.fewest) continue;
    squares += wall.across();
    points += wall.points;
  }
  return points > 0.0 ? std::sqrt(squares / points) : 0.0;
}

}  // namespace slam
