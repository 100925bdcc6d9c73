// SPDX-License-Identifier: BSD-3-Clause
#include "slam/map_import.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

namespace slam {
namespace {

constexpr double kSquare = 5.0;         // [m]
constexpr int kReach = 3;               // [cells] around a cell that a line is fitted to
constexpr int kMinCells = 4;            // that make a line
constexpr double kMaxThickness = 0.25;  // [1] of the line's spread: more is a corner
constexpr double kNormalSigma = 0.1;    // [rad] of a line through cells

bool occupied(const MapImage& image, int column, int row) {
  return column >= 0 && row >= 0 && column < image.width && row < image.height &&
         image.at(column, row) == MapImage::kOccupied;
}

bool free(const MapImage& image, int column, int row) {
  return column >= 0 && row >= 0 && column < image.width && row < image.height &&
         image.at(column, row) == MapImage::kFree;
}

/// Sum of the unit steps towards the free cells beside a cell; zero inside walls.
Eigen::Vector2d towardsFree(const MapImage& image, int column, int row) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int r = -1; r <= 1; ++r) {
    for (int c = -1; c <= 1; ++c) {
      if (free(image, column + c, row + r)) sum += Eigen::Vector2d(c, r);
    }
  }
  return sum;
}

bool border(const MapImage& image, int column, int row) {
  return occupied(image, column, row) && (free(image, column - 1, row) || free(image, column + 1, row) ||
                                          free(image, column, row - 1) || free(image, column, row + 1));
}

/// Normal of the line through the border cells around a cell, towards free space; zero where there is no line.
Eigen::Vector2d normalAt(const MapImage& image, int column, int row) {
  const Eigen::Vector2d side = towardsFree(image, column, row);
  if (side.isZero()) return side;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  int count = 0;
  for (int r = -kReach; r <= kReach; ++r) {
    for (int c = -kReach; c <= kReach; ++c) {
      if (!border(image, column + c, row + r)) continue;
      if (towardsFree(image, column + c, row + r).dot(side) <= 0.0) continue;  // the other side of a thin wall
      const Eigen::Vector2d d(c, r);
      sum += d;
      squares += d * d.transpose();
      ++count;
    }
  }
  if (count < kMinCells) return Eigen::Vector2d::Zero();
  const Eigen::Matrix2d scatter = squares / count - sum * sum.transpose() / (count * count);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> lines(scatter);
  if (lines.eigenvalues()(0) > kMaxThickness * lines.eigenvalues()(1)) return Eigen::Vector2d::Zero();
  const Eigen::Vector2d normal = lines.eigenvectors().col(0);
  return normal.dot(side) < 0.0 ? Eigen::Vector2d(-normal) : normal;
}

}  // namespace

MapState importMap(const MapImage& image) {
  std::map<std::pair<int, int>, std::shared_ptr<StoredScan>> squares;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const bool is_free = free(image, column, row);
      if (!is_free && !occupied(image, column, row)) continue;
      const double x = image.origin_x + (column + 0.5) * image.resolution;
      const double y = image.origin_y + (row + 0.5) * image.resolution;
      const std::pair square{static_cast<int>(std::floor(y / kSquare)), static_cast<int>(std::floor(x / kSquare))};
      auto& scan = squares[square];
      if (!scan) scan = std::make_shared<StoredScan>();
      const Eigen::Vector2f p(static_cast<float>(x - (square.second + 0.5) * kSquare),
                              static_cast<float>(y - (square.first + 0.5) * kSquare));
      if (!border(image, column, row)) {
        (is_free ? scan->free : scan->solid).push_back(p);
        continue;
      }
      Keyframe::Point point{.x = p.x(), .y = p.y()};
      const Eigen::Vector2d normal = normalAt(image, column, row);
      if (!normal.isZero()) {
        point.normal =
            static_cast<std::int16_t>(std::lround(std::atan2(normal.y(), normal.x()) / Keyframe::Point::kAngle));
        point.normal_sigma = static_cast<std::uint16_t>(kNormalSigma / Keyframe::Point::kAngle);
      }
      scan->points.push_back(point);
    }
  }
  MapState map;
  map.kind = MapKind::kFloorPlan;
  for (const auto& [square, scan] : squares) {
    map.keyframes.add(scan, {(square.second + 0.5) * kSquare, (square.first + 0.5) * kSquare, 0.0});
  }
  map.in_map.assign(squares.size(), 1);
  map.grid = toGrid(image);
  map.grid_keyframes = map.keyframes.size();
  return map;
}

}  // namespace slam
