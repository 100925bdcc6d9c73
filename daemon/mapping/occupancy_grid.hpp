// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/keyframe.hpp"
#include "core/tiled_grid.hpp"

namespace slam {

/// Inverse sensor model of one layer: what one look at a cell says about it.
struct InverseSensorModel {
  double hit_probability = 0.70;   ///< [1] P(occupied | a beam ended in the cell)
  double miss_probability = 0.33;  ///< [1] P(occupied | a beam went through the cell)
  double min_probability = 0.05;   ///< [1] clamp: a cell never gets surer of being free, so that it can change again
  double max_probability = 0.97;   ///< [1] clamp: 8 clear looks make a sure obstacle free again
};

struct OccupancyGridConfig {
  double resolution = 0.05;  ///< [m] side of a cell
  double max_range = 30.0;   ///< [m] longer returns are not drawn
  InverseSensorModel lidar;
};

/// log(p / (1 - p)) in units of 1/kLogOddsScale; 0 is p = 0.5, and a cell that was never seen.
using LogOdds = std::int16_t;
inline constexpr double kLogOddsScale = 1000.0;

inline LogOdds toLogOdds(double probability) {
  return static_cast<LogOdds>(std::lround(kLogOddsScale * std::log(probability / (1.0 - probability))));
}
inline double toProbability(LogOdds log_odds) { return 1.0 / (1.0 + std::exp(-log_odds / kLogOddsScale)); }

/// Occupancy grid with a lidar layer. Cell (0, 0) has its lower-left corner at the map frame's origin.
class OccupancyGrid {
 public:
  static constexpr int kTileSide = 64;
  struct Cell {
    LogOdds log_odds = 0;
    std::uint16_t scan = 0;  // serial of the scan that changed it last: a scan changes a cell once
  };
  using Tiles = TiledGrid<Cell, kTileSide>;

  explicit OccupancyGrid(const OccupancyGridConfig& config = {});

  /// Draws one scan: first the cells its beams ended in, then those they crossed, so that a grazing beam does not
  /// erase the wall its neighbour hit. Each cell changes once.
  void add(const Pose2& T_map_base, const Pose2& T_base_lidar, std::span<const Keyframe::Point> points);
  void add(const Keyframe& keyframe) { add(keyframe.T_map_base, keyframe.T_base_lidar, keyframe.points()); }
  /// Writes one cell, as of a stored map.
  void set(CellIndex cell, LogOdds log_odds);
  /// Tiles that the last scan changed, each once.
  const std::vector<TileIndex>& touched() const { return touched_; }

  /// A grid that draws only into the tiles given, for drawing part of a map anew.
  static OccupancyGrid patch(const OccupancyGridConfig& config, std::span<const TileIndex> tiles);
  /// Puts the tiles of a patch into the places of ours.
  void replaceBy(OccupancyGrid&& patch);

  /// A copy of the cells.
  OccupancyGrid clone() const;

  CellIndex cellAt(const Eigen::Vector2d& p_map) const {
    return {static_cast<int>(std::floor(p_map.x() * inverse_resolution_)),
            static_cast<int>(std::floor(p_map.y() * inverse_resolution_))};
  }
  double resolution() const { return config_.resolution; }
  const Tiles& tiles() const { return tiles_; }
  LogOdds logOdds(CellIndex cell) const { return tiles_.read(cell).log_odds; }

  /// Tiles changed since the last call, each once, in the order of change.
  std::vector<TileIndex> takeChangedTiles();

 private:
  void change(CellIndex cell, LogOdds by);
  void enter(TileIndex tile);
  void markChanged(TileIndex tile);

  OccupancyGridConfig config_;
  double inverse_resolution_;
  LogOdds hit_, miss_, min_, max_;
  Tiles tiles_;
  std::uint16_t scan_ = 0;
  bool grows_ = true;  // false: a patch
  struct Pen {
    TileIndex index;
    Tiles::Tile* tile = nullptr;  // nullptr: outside a patch
    bool touched = false;         // is in touched_
  } pen_;                         // the tile being drawn into: most cells of a ray lie in the one before's
  std::vector<TileIndex> changed_, touched_;
  std::vector<CellIndex> ends_;  // of the present keyframe's beams
};

}  // namespace slam
