// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/pose2.hpp"

namespace slam {

struct GlobalSearchConfig {
  double cell = 0.10;               ///< [m] of the finest level; more where a map would need more than max_cells
  int max_cells = 1 << 22;          ///< of a level: bounds the memory, one byte a cell and level
  int levels = 6;                   ///< the coarsest one steps by 2^(levels - 1) cells
  double kernel_sigma = 0.15;       ///< [m] a point this far from a wall has lost 40 % of its score
  double distinct_distance = 0.75;  ///< [m] results further apart than this ...
  double distinct_rotation = 0.35;  ///< [rad] ... or this are two places
  double kernel_sigmas = 2.5;       ///< [1] of the kernel, then it is 0
  double turn_step = 1.5;           ///< [cells] that a point at mean range moves at a step of the turn
};

/// Where a query may lie in a map.
struct GlobalPlace {
  Pose2 T_map_query;
  double score = 0.0;  ///< [1] mean over the points: 1 when all lie on walls
};

/// Poses around a guess.
struct PlaceWindow {
  Pose2 T_map_query;
  double translation = 0.0, rotation = 0.0;  ///< [m], [rad] to either side

  bool holds(const Pose2& pose) const;
};

/// Finds points in a whole map without a guess: branch and bound over a pyramid of smoothed walls, exact on its grid of
/// poses. [Hess 2016] W. Hess et al., "Real-time loop closure in 2D LIDAR SLAM", Proc. ICRA 2016, section V.
///
/// Built once for a map; searching does not change it. Allocates.
class GlobalSearch {
 public:
  /// @param walls [m] points of the map's walls
  explicit GlobalSearch(std::span<const Eigen::Vector2d> walls, const GlobalSearchConfig& config = {});

  /// @param query     [m] points in the query's frame, whose origin the robot stands near; the cost grows with their
  ///                  number
  /// @param min_score [1] no place with less is looked for
  /// @param most      places looked for
  /// @param share     [1] of the best place's score that the others reach at least
  /// @param around    only places in this window; none: anywhere
  /// @return the best place and the best ones elsewhere, best first
  std::vector<GlobalPlace> search(std::span<const Eigen::Vector2d> query, double min_score, int most, double share,
                                  const std::optional<PlaceWindow>& around = {}) const;

 private:
  struct Pose {
    int turn, column, row;
  };
  struct Query;
  struct Level {
    int reach = 0;                     // cells that it covers, to the right and up
    std::vector<std::uint8_t> values;  // of the coarsest one none
  };
  /// The coarsest level. All its blocks are looked at, a step apart: of each place within a step it has a plane, on
  /// which they lie side by side.
  struct Planes {
    int step = 0, columns = 0, rows = 0;  // of a plane
    std::vector<std::uint8_t> values;

    std::size_t planeSize() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
    /// Where in `values` the plane of a place within a step begins.
    std::size_t begin(int column, int row) const { return static_cast<std::size_t>(row * step + column) * planeSize(); }
  };

  static constexpr int kMostLevels = 32;
  struct Block {
    Pose pose;  // its lower left corner
    int level, bound;
    int order() const { return bound * kMostLevels - level; }  // depth first among equals
    bool operator<(const Block& other) const { return order() < other.order(); }
  };
  std::vector<Block> coarseBlocks(const Query& query, int threshold, const std::optional<PlaceWindow>& around) const;
  std::array<int, 4> scoreQuarters(const Query& query, int level, const Pose& pose) const;
  /// 0 beyond the border, on the coarsest level neither: the margin is as wide as that one reaches.
  int valueAt(const std::uint8_t* values, int column, int row) const {
    if (static_cast<unsigned>(column) >= static_cast<unsigned>(columns_)) return 0;
    if (static_cast<unsigned>(row) >= static_cast<unsigned>(rows_)) return 0;
    return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)];
  }
  void branch(const Query& query, const Block& block, int threshold, std::vector<Block>& open) const;
  bool elsewhere(const Query& query, const Pose& block, int width, std::span<const Pose> known) const;
  Pose2 toPose(const Query& query, const Pose& pose) const;

  GlobalSearchConfig config_;
  double cell_ = 0.1;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();  // lower-left corner of cell (0, 0) of the finest level
  int columns_ = 0, rows_ = 0, margin_ = 0;           // of all levels
  std::vector<Level> levels_;                         // finest first
  Planes coarsest_;
};

}  // namespace slam
