// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace slam {

/// Which nodes lie near a place: a hashed grid, so that asking costs what lies there, however large the map is.
class NodeIndex {
 public:
  /// Adds the node that follows the last one. @param p_map [m]
  void add(const Eigen::Vector2d& p_map);
  void move(int node, const Eigen::Vector2d& p_map);
  /// Forgets the nodes from `count` on.
  void truncate(int count);
  /// All nodes within `radius` [m] of a place, and some beyond, in no order.
  std::vector<int> candidates(const Eigen::Vector2d& p_map, double radius) const;

 private:
  using Cell = std::uint64_t;
  std::int32_t coordinate(double metres) const;
  static Cell cell(std::int32_t x, std::int32_t y);
  void erase(int node);

  double cell_ = 5.0;                                 // [m] a side
  std::vector<Cell> cell_of_;                         // by node
  std::unordered_map<Cell, std::vector<int>> nodes_;  // by cell
};

}  // namespace slam
