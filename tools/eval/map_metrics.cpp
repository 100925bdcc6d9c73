// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/map_metrics.hpp"

#include <cmath>

namespace slam {
namespace {

Eigen::Vector2d centre(const MapImage& image, int column, int row) {
  return {image.origin_x + (column + 0.5) * image.resolution, image.origin_y + (row + 0.5) * image.resolution};
}

std::uint8_t lookUp(const MapImage& image, const Eigen::Vector2d& p) {
  const int column = static_cast<int>(std::floor((p.x() - image.origin_x) / image.resolution));
  const int row = static_cast<int>(std::floor((p.y() - image.origin_y) / image.resolution));
  if (column < 0 || row < 0 || column >= image.width || row >= image.height) return MapImage::kUnknown;
  return image.at(column, row);
}

/// Is there an occupied cell within one cell of p?
bool occupiedNear(const MapImage& image, const Eigen::Vector2d& p, double reach) {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (lookUp(image, p + reach * Eigen::Vector2d(dx, dy)) == MapImage::kOccupied) return true;
    }
  }
  return false;
}

PrecisionRecall score(int right_of_claimed, int claimed, int found_of_true, int true_cells) {
  PrecisionRecall result;
  result.precision = claimed > 0 ? static_cast<double>(right_of_claimed) / claimed : 0.0;
  result.recall = true_cells > 0 ? static_cast<double>(found_of_true) / true_cells : 0.0;
  const double sum = result.precision + result.recall;
  result.f1 = sum > 0.0 ? 2.0 * result.precision * result.recall / sum : 0.0;
  return result;
}

}  // namespace

MapErrors compareMaps(const MapImage& map, const MapImage& truth, const Pose2& T_truth_map) {
  MapErrors errors;
  const double reach = std::max(map.resolution, truth.resolution);
  int open = 0, false_obstacles = 0;
  int true_occupied = 0, found_occupied = 0, true_free = 0, found_free = 0, known = 0;
  const Pose2 T_map_truth = T_truth_map.inverse();
  for (int row = 0; row < truth.height; ++row) {
    for (int column = 0; column < truth.width; ++column) {
      const std::uint8_t value = truth.at(column, row);
      if (value == MapImage::kUnknown) continue;
      const Eigen::Vector2d p = T_map_truth * centre(truth, column, row);
      ++errors.compared;
      if (lookUp(map, p) != MapImage::kUnknown) ++known;
      if (value == MapImage::kOccupied) {
        ++true_occupied;
        if (occupiedNear(map, p, reach)) ++found_occupied;
      } else {
        ++true_free;
        if (lookUp(map, p) == MapImage::kFree) ++found_free;
        if (occupiedNear(truth, centre(truth, column, row), truth.resolution)) continue;
        ++open;
        if (lookUp(map, p) == MapImage::kOccupied) ++false_obstacles;
      }
    }
  }
  int claimed_occupied = 0, right_occupied = 0, claimed_free = 0, right_free = 0;
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      const std::uint8_t value = map.at(column, row);
      const Eigen::Vector2d p = T_truth_map * centre(map, column, row);
      const std::uint8_t true_value = lookUp(truth, p);
      if (value == MapImage::kOccupied) {
        const bool near = occupiedNear(truth, p, reach);
        if (true_value == MapImage::kUnknown && !near) continue;  // nobody knows
        ++claimed_occupied;
        if (near) ++right_occupied;
      } else if (value == MapImage::kFree && true_value != MapImage::kUnknown) {
        ++claimed_free;
        if (true_value == MapImage::kFree) ++right_free;
      }
    }
  }
  errors.occupied = score(right_occupied, claimed_occupied, found_occupied, true_occupied);
  errors.free = score(right_free, claimed_free, found_free, true_free);
  errors.false_obstacles = open > 0 ? static_cast<double>(false_obstacles) / open : 0.0;
  errors.completeness = errors.compared > 0 ? static_cast<double>(known) / errors.compared : 0.0;
  return errors;
}

}  // namespace slam
