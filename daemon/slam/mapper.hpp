// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/keyframe.hpp"
#include "mapping/occupancy_grid.hpp"

namespace slam {

/// A scan with the pose to draw it at.
struct MapScan {
  int id = -1;  ///< of the keyframe; -1: a look, drawn once and forgotten
  Pose2 T_map_base;
  std::shared_ptr<const StoredScan> scan;
};

/// Draws keyframes and looks into the grid, and draws anew what a loop closure moved.
///
/// move() only notes the new poses. work() then draws the tiles that moved keyframes lie on, old place and new, from
/// all keyframes that touch them, into a patch beside the grid, a few scans at a call; the finished patch takes the
/// tiles' places at once. The result is the grid that drawing all keyframes at their new poses would give, give or take
/// keyframes that moved by less than a fifth of a cell.
///
/// Not safe for concurrent use.
class Mapper {
 public:
  explicit Mapper(const OccupancyGridConfig& config = {}) : configured_(config), config_(config), grid_(config) {}

  void add(const MapScan& scan);
  /// @param T_map_base new poses by keyframe id; further ones stay
  void move(std::span<const Pose2> T_map_base);
  /// Draws up to `scans` scans of what is left to draw anew. @return true while something is left
  bool work(int scans);
  /// Goes on in a stored map: its keyframes, and the grid that they and looks were drawn into.
  /// @param drawn keyframes with lower ids are in the grid; the others are drawn now
  void load(std::span<const MapScan> keyframes, OccupancyGrid grid, int drawn);
  /// Forgets the map.
  void reset();

  const OccupancyGrid& grid() const { return grid_; }
  std::vector<TileIndex> takeChangedTiles() { return grid_.takeChangedTiles(); }
  int keyframes() const { return static_cast<int>(keyframes_.size()); }
  /// [m] positions of the keyframes in map
  std::vector<Eigen::Vector2d> path() const;

 private:
  struct Drawn {
    int id;
    std::shared_ptr<const StoredScan> scan;
    Pose2 T_map_base, T_map_base_drawn;
    std::vector<TileIndex> tiles;  // touched where it is drawn
  };
  struct Moved {
    std::size_t keyframe;
    Pose2 T_map_base;
    std::vector<TileIndex> tiles;  // where it will be drawn
  };
  struct Redraw {
    std::size_t examined = 0;      // keyframes looked at for having moved
    std::vector<Moved> moved;      // by keyframe
    std::vector<TileIndex> dirty;  // sorted once all are examined
    std::optional<OccupancyGrid> patch;
    std::vector<std::pair<std::size_t, Pose2>> scans;  // keyframes to draw and where
    std::size_t next = 0;
  };
  bool hasMoved(const Drawn& keyframe) const;
  int examine(int scans);
  void preparePatch();
  void finishRedraw();

  OccupancyGridConfig configured_, config_;  // of a new map, of this one
  OccupancyGrid grid_;
  std::vector<Drawn> keyframes_;
  std::optional<Redraw> redraw_;
};

}  // namespace slam
