// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/depth_view.hpp"
#include "core/keyframe.hpp"
#include "mapping/edited_drawing.hpp"
#include "mapping/occupancy_grid.hpp"

namespace slam {

/// A scan with the pose to draw it at.
struct MapScan {
  int id = -1;  ///< of the keyframe; -1: a refresh, drawn once and forgotten
  Pose2 T_map_base;
  std::shared_ptr<const StoredScan> scan;
};

/// What the depth camera saw near a keyframe, with which it moves.
struct MapView {
  int keyframe = -1;  ///< id
  Pose2 T_map_keyframe, T_keyframe_base;
  std::shared_ptr<const DepthView> view;
  int edit = 0;  ///< the newest edit of the map when it was seen; 0: there was none

  Pose2 T_map_base() const { return T_map_keyframe * T_keyframe_base; }
};

/// A view without what edits erased of it; the same one where they erased nothing.
std::shared_ptr<const DepthView> shownOf(const MapView& view, std::span<const EditedDrawing::Erased> erased);

/// The Mapper's share of a map: what is drawn, and the depth views it was drawn from.
struct DrawnMap {
  OccupancyGrid grid;
  std::vector<MapView> views;
};

/// Which depth views are kept to be drawn anew: a few for each keyframe, so that a known place costs no memory however
/// long the robot stays. A newer view takes the place of an older one from the same place.
struct ViewMemoryConfig {
  std::size_t per_keyframe = 3;  ///< views, then the newest takes the place of the oldest
  double same_distance = 0.15;   ///< [m] views nearer than this ...
  double same_rotation = 0.20;   ///< [rad] ... and turned by less are of the same place
};

/// Draws keyframes, refreshes and depth views into the grid, and draws anew what a loop closure moved.
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

  /// Of a keyframe that is drawn already, whose scan has lost points, the new scan takes the place of the old one.
  void add(const MapScan& scan);
  void add(const MapView& view);
  /// @param T_map_base new poses by keyframe id; further ones stay
  void move(std::span<const Pose2> T_map_base);
  /// Draws anew what the edits of the map change. @param anew whatever was drawn within them [m, in map]
  void apply(const EditedDrawing& edits, std::span<const Outline> anew = {});
  /// Forgets keyframes with lower ids, if there are any, and what the depth camera saw near them; at once.
  void forgetBefore(int keyframe);
  /// Draws up to `scans` scans of what is left to draw anew. @return true while something is left
  bool work(int scans);
  /// Goes on in a stored map: its keyframes, and the grid that they and refreshes were drawn into.
  /// @param drawn keyframes with lower ids are in the grid; the others are drawn now
  /// @param views that the grid shows already
  /// @param edits that the grid shows already
  void load(std::span<const MapScan> keyframes, std::span<const MapView> views, OccupancyGrid grid, int drawn,
            const EditedDrawing& edits = {});
  /// Forgets the map.
  void reset();

  const OccupancyGrid& grid() const { return grid_; }
  std::vector<TileIndex> takeChangedTiles() { return grid_.takeChangedTiles(); }
  int keyframes() const { return keyframes_; }
  /// The depth views kept.
  std::vector<MapView> views() const;
  /// [m] positions of the keyframes in map
  std::vector<Eigen::Vector2d> path() const;

 private:
  struct Drawn {
    int keyframe;                            // that it moves with
    Pose2 T_keyframe_base;                   // identity: the keyframe's own scan
    std::shared_ptr<const StoredScan> scan;  // one of these two
    std::shared_ptr<const DepthView> view;
    Pose2 T_map_keyframe, T_map_base_drawn;
    std::vector<TileIndex> tiles;                      // touched where it is drawn
    bool stale = false;                                // what is drawn is another scan
    int edit = 0;                                      // of a view: the newest one when it was seen
    std::shared_ptr<const DepthView> shown = nullptr;  // of a view: what is drawn of it

    Pose2 T_map_base() const { return T_map_keyframe * T_keyframe_base; }
    void drawInto(OccupancyGrid& grid, const Pose2& T_map_base) const;
  };
  struct Moved {
    std::size_t index;
    Pose2 T_map_base;
    std::vector<TileIndex> tiles;  // where it will be drawn
  };
  struct Redraw {
    std::size_t examined = 0;      // of drawn_, looked at for having moved
    std::vector<Moved> moved;      // by index
    std::vector<TileIndex> dirty;  // sorted once all are examined
    std::optional<OccupancyGrid> patch;
    std::vector<std::pair<std::size_t, Pose2>> scans;  // what to draw of drawn_ and where
    std::size_t next = 0;
  };
  bool hasMoved(const Drawn& drawn) const;
  void draw(const Drawn& drawn);
  static Drawn drawnOf(const MapView& view, std::span<const EditedDrawing::Erased> erased);
  void keep(Drawn drawn);
  void keepLate();
  Drawn* drawnScan(int keyframe);
  std::size_t* placeOf(const Drawn& view);
  int examine(int scans);
  void preparePatch();
  void finishRedraw();

  OccupancyGridConfig configured_, config_;  // of a new map, of this one
  OccupancyGrid grid_;
  std::vector<Drawn> drawn_;
  int keyframes_ = 0;                               // of these
  std::vector<std::vector<std::size_t>> views_of_;  // in drawn_, by keyframe
  std::optional<Redraw> redraw_;
  FreeCells free_;
  std::vector<EditedDrawing::Erased> erased_;
  std::vector<TileIndex> edited_;  // tiles that edits changed, until they are drawn anew
  std::vector<Drawn> late_;        // views that came during it: drawn, and kept when it is over
};

}  // namespace slam
