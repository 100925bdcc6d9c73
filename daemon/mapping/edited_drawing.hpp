// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <bitset>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/pose2.hpp"
#include "mapping/occupancy_grid.hpp"
#include "mapping/outline.hpp"

namespace slam {

/// What the edits of a map ask of its drawing.
struct EditedDrawing {
  /// What left a part of the depth views that there were.
  struct Erased {
    int edit = 0;                         ///< views that were seen after it keep all
    Outline outline;                      ///< [m] in map as it was then
    std::map<int, Pose2> T_keyframe_map;  ///< the same, by the keyframe that a view was seen near
  };
  std::vector<Outline> free;   ///< [m] in map: no cell that they cover or touch is occupied
  std::vector<Erased> erased;  ///< by their edits
};

/// The cells that outlines cover or touch, tile by tile; what no one asks for is not worked out.
class FreeCells {
 public:
  using Mask = std::bitset<OccupancyGrid::kTileSide * OccupancyGrid::kTileSide>;  ///< row by row

  FreeCells() = default;
  /// @param resolution [m] side of a cell
  FreeCells(std::vector<Outline> outlines, double resolution);
  bool empty() const { return outlines_.empty(); }
  const std::vector<Outline>& outlines() const { return outlines_; }
  /// Makes the cells of some tiles of a grid free, where something is known of them.
  void apply(OccupancyGrid& grid, std::span<const TileIndex> tiles);

 private:
  const Mask* maskOf(TileIndex tile);

  std::vector<Outline> outlines_;
  std::vector<Bounds> bounds_;                                // of each
  double resolution_ = 0.0;                                   // [m]
  std::map<std::pair<int, int>, std::optional<Mask>> masks_;  // by row and column; nullopt: nothing lies in the tile
};

/// Tiles of a grid that an outline may reach into.
std::vector<TileIndex> tilesUnder(const Outline& outline, const OccupancyGrid& grid);

}  // namespace slam
