// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "posegraph/keyframe_graph.hpp"

namespace slam {

struct WallFieldConfig {
  double cell = 0.10;        ///< [m] more where a map would need more than max_cells
  int max_cells = 1 << 22;   ///< bounds the memory, five bytes a cell
  double reach = 2.0;        ///< [m] the nearest wall is known up to here
  double before_end = 0.30;  ///< [m] a beam shows free space up to so much before its end
};

/// The walls of a whole map on a raster: which one is nearest, what is known to be free, and what a line of sight
/// meets. Built once for a map. Allocates.
class WallField {
 public:
  WallField(const KeyframeGraph& keyframes, std::span<const int> map, const WallFieldConfig& config = {});

  struct Wall {
    Eigen::Vector2d position;  ///< [m] in map
    Eigen::Vector2d normal;    ///< unit, towards free space; zero where there is no line
    bool isLine() const { return !normal.isZero(); }
  };
  std::span<const Wall> walls() const { return walls_; }
  /// The wall nearest to a point, give or take a cell; nullptr: none within reach.
  const Wall* nearest(const Eigen::Vector2d& p_map) const;
  /// Whether the map has seen that nothing is there.
  bool free(const Eigen::Vector2d& p_map) const { return is(Known::kFree, p_map); }
  /// Whether it is within a wall: noisy scans drew it thicker than it is, and its face may be anywhere in there.
  bool solid(const Eigen::Vector2d& p_map) const { return is(Known::kSolid, p_map); }
  /// Faces and insides of the walls [m].
  std::vector<Eigen::Vector2d> wallPoints() const;
  /// The first wall that a line of sight enters more than `before` [m] ahead of its end, if any. One that grazes a wall
  /// may lie on either side of it and is let through.
  const Wall* blocking(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double before) const;

 private:
  enum class Known : std::uint8_t { kNothing, kFree, kSolid };
  bool is(Known what, const Eigen::Vector2d& p_map) const {
    const auto i = index(p_map);
    return i >= 0 && known_[static_cast<std::size_t>(i)] == what;
  }
  void collect(const KeyframeGraph& keyframes, std::span<const int> map);
  void spread();
  void mark(const KeyframeGraph& keyframes, std::span<const int> map);
  /// @return -1 outside
  std::int64_t index(const Eigen::Vector2d& p_map) const;

  WallFieldConfig config_;
  double cell_ = 0.1;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int columns_ = 0, rows_ = 0;
  std::vector<Wall> walls_;
  std::vector<std::int32_t> nearest_;  // -1: none
  std::vector<Known> known_;
  std::vector<Eigen::Vector2d> solid_;  // [m] in map
};

}  // namespace slam
