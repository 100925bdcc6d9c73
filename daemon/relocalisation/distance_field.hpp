// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "graph/keyframe_graph.hpp"

namespace slam {

/// What a map is made of.
enum class MapKind : std::uint8_t {
  kScans,      ///< keyframes of the robot's own lidar, whose beams show what is free
  kFloorPlan,  ///< an occupancy map of unknown origin, whose keyframes say themselves what is free and solid
};

struct DistanceFieldConfig {
  MapKind kind = MapKind::kScans;
  double cell = 0.10;        ///< [m] more where a map would need more than max_cells
  int max_cells = 1 << 22;   ///< bounds the memory, five bytes a cell
  double reach = 2.0;        ///< [m] the nearest wall is known up to here
  double margin = 0.0;       ///< [m] of the raster, beyond that, around all walls
  double before_end = 0.30;  ///< [m] a beam shows free space up to so much before its end
};

/// Visits the faces and insides of a map's walls [m], in map.
void forEachWallPoint(const KeyframeGraph& keyframes, std::span<const int> map,
                      const std::function<void(const Eigen::Vector2d&)>& visit);

/// The walls of a whole map on a raster: which one is nearest, what is solid and what is known to be free. Built once
/// for a map. Allocates.
class DistanceField {
 public:
  DistanceField(const KeyframeGraph& keyframes, std::span<const int> map, const DistanceFieldConfig& config = {});

  struct Wall {
    Eigen::Vector2d position;  ///< [m] in map
    Eigen::Vector2d normal;    ///< unit, towards free space; zero where there is no line
    bool isLine() const { return !normal.isZero(); }
  };
  /// At most one a cell, of a floor plan all.
  std::span<const Wall> walls() const { return walls_; }
  /// The wall nearest to a point, give or take a cell; nullptr: none within reach.
  const Wall* nearest(const Eigen::Vector2d& p_map) const;
  /// Mean thickness of the walls [m], drawn thicker by noise than they are. 0: there are none.
  double thickness() const { return thickness_; }

  /// What the map knows of a cell; kSolid: a wall, or within one.
  enum class Known : std::uint8_t { kNothing, kFree, kSolid };
  Known known(std::size_t cell) const { return known_[cell]; }
  Known known(int column, int row) const;  ///< outside: nothing
  /// Cell of a point, row by row; -1: outside.
  std::int64_t index(const Eigen::Vector2d& p_map) const;
  /// Of a column and a row that are inside.
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }
  double cell() const { return cell_; }           ///< [m]
  double reach() const { return config_.reach; }  ///< [m]
  int columns() const { return columns_; }
  int rows() const { return rows_; }

 private:
  void collect(const KeyframeGraph& keyframes, std::span<const int> map);
  double distance(int column, int row, const Wall& wall) const;  // [m] from a cell's middle
  const Wall& wallAt(std::int32_t wall) const { return walls_[static_cast<std::size_t>(wall)]; }
  void spread();
  void mark(const KeyframeGraph& keyframes, std::span<const int> map);
  void measure();
  std::int64_t cellAt(const Eigen::Vector2d& at) const;  // [cells] from the origin; -1: outside

  DistanceFieldConfig config_;
  double cell_ = 0.1, thickness_ = 0.0;  // [m]
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int columns_ = 0, rows_ = 0;
  std::vector<Wall> walls_;
  std::vector<std::int32_t> nearest_;  // -1: none
  std::vector<Known> known_;
};

}  // namespace slam
