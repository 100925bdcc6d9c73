// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
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
  std::size_t points_at_once = 24;  ///< are compared before a look whether a block can still be worth it
  std::int64_t block_work = 64;     ///< [points] that are compared in the time that the heap needs for a block
  std::int64_t coarse_at_once = 8;  ///< blocks of the coarsest level that are compared in the time of four of another
  std::size_t max_open = 1 << 20;   ///< blocks of poses kept to be divided: bounds the memory of a search to 40 MB
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
  struct Pose {
    int turn, column, row;
  };
  /// The points turned to each direction, in cells.
  struct Query {
    struct Point {
      int column, row;
    };
    int turns = 0;
    double step = 0.0;          // [rad]
    int count = 0;              // points
    std::vector<Point> points;  // turn by turn
    std::span<const Point> at(int turn) const {
      return {points.data() + static_cast<std::size_t>(turn) * static_cast<std::size_t>(count),
              static_cast<std::size_t>(count)};
    }
  };
  static constexpr int kMostLevels = 32;
  struct Block {
    Pose pose;  // its lower left corner
    int level, bound;
    int order() const { return bound * kMostLevels - level; }  // depth first among equals
    bool operator<(const Block& other) const { return order() < other.order(); }
  };

 public:
  /// Gives each of a map's walls' points [m] to a visitor.
  using Walls = std::function<void(const std::function<void(const Eigen::Vector2d&)>&)>;
  /// @param walls are gone through twice, and not kept
  explicit GlobalSearch(const Walls& walls, const GlobalSearchConfig& config = {});
  explicit GlobalSearch(std::span<const Eigen::Vector2d> walls, const GlobalSearchConfig& config = {});

  /// A search under way, of a map that stays the same.
  class Search {
   public:
    bool done() const { return done_; }
    /// @pre done() @return whether nothing that might be among its places was left out, because it found no room
    bool complete() const { return left_out_ <= threshold_ || (full() && left_out_ <= last_); }
    /// The best place so far and the best ones elsewhere, best first.
    std::span<const GlobalPlace> places() const { return places_; }

   private:
    friend class GlobalSearch;
    bool full() const { return static_cast<int>(places_.size()) >= most_; }
    void leaveOutWorst(std::size_t max_open);

    Query query_;
    int threshold_ = 0, most_ = 0, turn_ = 0;  // turn_: whose blocks are laid out next
    double share_ = 1.0;
    std::optional<PlaceWindow> around_;
    std::vector<Block> open_;  // a heap once all turns are laid out
    std::vector<Pose> known_;
    std::vector<GlobalPlace> places_;
    int left_out_ = 0, last_ = 0;  // highest bound of a block that was left out, score of the last place
    bool done_ = false;
  };

  /// @param query     [m] points in the query's frame, whose origin the robot stands near; the cost grows with their
  ///                  number
  /// @param min_score [1] no place with less is looked for
  /// @param most      places looked for
  /// @param share     [1] of the best place's score that the others reach at least
  /// @param around    only places in this window; none: anywhere
  Search begin(std::span<const Eigen::Vector2d> query, double min_score, int most, double share,
               const std::optional<PlaceWindow>& around = {}) const;
  /// Takes a search further, until it is done or the work is.
  /// @param work [points] to be compared with the map's walls, less what was; ends below zero by one step at most
  void goOn(Search& search, std::int64_t& work) const;
  /// Begins one and goes on until it is done.
  /// @return the best place and the best ones elsewhere, best first
  std::vector<GlobalPlace> search(std::span<const Eigen::Vector2d> query, double min_score, int most, double share,
                                  const std::optional<PlaceWindow>& around = {}) const;

 private:
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

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }
  /// The finest level: a cell's value is that of the nearest point, so the kernel is computed once for a cell and not
  /// for each point.
  std::vector<std::uint8_t> smoothed(const Walls& walls) const;
  void addLevel(std::size_t level);
  void addCoarseBlocks(Search& search, std::int64_t& work) const;
  std::array<int, 4> scoreQuarters(const Query& query, const Block& block, int threshold, std::int64_t& work) const;
  /// 0 beyond the border, on the coarsest level neither: the margin is as wide as that one reaches.
  int valueAt(const std::uint8_t* values, int column, int row) const {
    if (static_cast<unsigned>(column) >= static_cast<unsigned>(columns_)) return 0;
    if (static_cast<unsigned>(row) >= static_cast<unsigned>(rows_)) return 0;
    return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)];
  }
  void branch(Search& search, const Block& block, std::int64_t& work) const;
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
