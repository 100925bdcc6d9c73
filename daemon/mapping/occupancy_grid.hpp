// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <bitset>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/depth_view.hpp"
#include "core/keyframe.hpp"
#include "core/tiled_grid.hpp"
#include "mapping/layer_fusion.hpp"

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
  double max_range = 30.0;   ///< [m] longer returns of the lidar are not drawn
  Fusion fusion = Fusion::kLayers;
  InverseSensorModel lidar = {}, depth = {};

  void visitSettings(auto& v) {
    v.site("resolution", resolution, "m", 0.005, 1.0, "One cell of the map has this side length.",
           "Lower it for narrow places, raise it to save memory in large halls.");
    v.expert("max_range", max_range, "m", 0.5, 200.0,
             "Lidar returns that are farther than this are not drawn into the map.");
    v.expert("fusion", fusion,
             "The lidar and the depth camera draw into layers of their own that later scans can clear (layers), or "
             "as in the paper (paper).");
    v.expert("hit_probability", lidar.hit_probability, "1", 0.51, 0.99,
             "A cell in which a lidar beam ended once is occupied with this probability.");
    v.expert("miss_probability", lidar.miss_probability, "1", 0.01, 0.49,
             "A cell that a lidar beam crossed once is occupied with this probability.");
    v.expert("min_probability", lidar.min_probability, "1", 0.001, 0.19,
             "The lidar never makes the probability that a cell is occupied lower than this.");
    v.expert("max_probability", lidar.max_probability, "1", 0.66, 0.999,
             "The lidar never makes the probability that a cell is occupied higher than this.");
    v.expert("depth_hit_probability", depth.hit_probability, "1", 0.51, 0.99,
             "A cell in which the depth camera saw an obstacle once is occupied with this probability.");
    v.expert("depth_miss_probability", depth.miss_probability, "1", 0.01, 0.49,
             "A cell through which the depth camera looked once at all heights is occupied with this probability.");
    v.expert("depth_min_probability", depth.min_probability, "1", 0.001, 0.19,
             "The depth camera never makes the probability that a cell is occupied lower than this.");
    v.expert("depth_max_probability", depth.max_probability, "1", 0.66, 0.999,
             "The depth camera never makes the probability that a cell is occupied higher than this.");
  }
};

enum class MapLayer : std::uint8_t { kBoth, kLidar, kDepth };

/// Occupancy grid with a lidar layer, which knows one height, and a depth layer, which knows the robot's whole height.
/// Cell (0, 0) has its lower-left corner at the map frame's origin.
class OccupancyGrid {
 public:
  static constexpr int kTileSide = 64;
  struct Cell {
    LogOdds lidar = 0, depth = 0;  ///< the layers
    std::uint16_t look = 0;        ///< serial of the scan or depth view that changed it last: each changes a cell once
    bool seen() const { return look != 0 || lidar != 0 || depth != 0; }
  };
  using Tiles = TiledGrid<Cell, kTileSide>;

  explicit OccupancyGrid(const OccupancyGridConfig& config = {});

  /// Draws one scan: first the cells its beams ended in, then those they crossed, so that a grazing beam does not
  /// erase the wall its neighbour hit. Each cell changes once.
  void add(const Pose2& T_map_base, const Pose2& T_base_lidar, std::span<const Keyframe::Point> points);
  void add(const Keyframe& keyframe) { add(keyframe.T_map_base, keyframe.T_base_lidar, keyframe.points()); }
  /// Draws what a depth camera saw, as add() of a scan does, into the depth layer.
  /// @param T_map_depth the camera, levelled
  void add(const Pose2& T_map_depth, const DepthView& view);
  /// Writes one cell, as of a stored map.
  void set(CellIndex cell, LogOdds lidar, LogOdds depth = 0);
  /// Makes cells of a tile free, in both layers, where something is known of them.
  /// @param cells by row * kTileSide + column
  void keepFree(TileIndex tile, const std::bitset<kTileSide * kTileSide>& cells);
  /// Tiles that the last scan or view changed, each once.
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
  /// Both layers as one, by the configured fusion.
  LogOdds fused(const Cell& cell) const { return slam::fused(config_.fusion, cell.lidar, cell.depth); }
  /// One of them, or both as one; std::nullopt where it has seen nothing.
  std::optional<LogOdds> seenBy(MapLayer layer, const Cell& cell) const {
    if (layer == MapLayer::kBoth) return cell.seen() ? std::optional(fused(cell)) : std::nullopt;
    const LogOdds value = layer == MapLayer::kLidar ? cell.lidar : cell.depth;
    return value != 0 ? std::optional(value) : std::nullopt;
  }
  LogOdds logOdds(CellIndex cell) const { return fused(tiles_.read(cell)); }

  /// Tiles changed since the last call, each once, in the order of change.
  std::vector<TileIndex> takeChangedTiles();

 private:
  /// A layer and how it changes.
  struct Layer {
    Layer(LogOdds Cell::*of_cell, const InverseSensorModel& model, Fusion fusion);
    LogOdds Cell::*value;
    LogOdds hit, miss, min, max;
    bool keeps_obstacles;  // [Paper eq. 19]
  };
  void begin();
  void change(CellIndex cell, const Layer& layer, LogOdds by);
  void draw(const Layer& layer);
  void enter(TileIndex tile);
  void markChanged(TileIndex tile);

  OccupancyGridConfig config_;
  double inverse_resolution_;
  Layer lidar_, depth_;
  Tiles tiles_;
  std::uint16_t look_ = 0;
  bool grows_ = true;  // false: a patch
  struct Pen {
    TileIndex index;
    Tiles::Tile* tile = nullptr;  // nullptr: outside a patch
    bool touched = false;         // is in touched_
  } pen_;                         // the tile being drawn into: most cells of a ray lie in the one before's
  std::vector<TileIndex> changed_, touched_;
  struct Ray {
    CellIndex from, to;  // `to` excluded
  };
  std::vector<CellIndex> hits_;  // of the present scan or view ...
  std::vector<Ray> rays_;        // ... and what it saw through
};

}  // namespace slam
