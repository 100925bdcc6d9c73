// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/pose2.hpp"
#include "core/scan.hpp"
#include "frontend/front_end_state.hpp"
#include "frontend/lidar_model.hpp"
#include "graph/keyframe_graph.hpp"
#include "mapping/mapper.hpp"
#include "mapping/occupancy_grid.hpp"
#include "relocalisation/distance_field.hpp"
#include "relocalisation/floor_atlas.hpp"
#include "slam/edits/map_edits.hpp"

namespace slam {

/// All that is needed to go on in a map another day.
struct MapState {
  KeyframeGraph keyframes;
  std::vector<char> in_map;  ///< by keyframe: 0 where its place in the map was never found
  OccupancyGrid grid;
  std::vector<MapView> views;      ///< of the depth camera; their keyframes' poses are those of `keyframes`
  int grid_keyframes = 0;          ///< so many keyframes are drawn into the grid; fewer than there are after a crash
  Pose2 T_map_base;                ///< where the robot was last
  double gyro_bias = 0.0;          ///< [rad/s]
  BodyShape body;                  ///< what moves with the robot
  Pose2 T_base_lidar;              ///< extrinsics that the keyframes were taken with
  double range_max = 0.0;          ///< [m] of the lidar
  std::int64_t utime = 0;          ///< [us] of the last keyframe
  MapEdits edits;                  ///< what they erase is not in the scans of `keyframes`
  MapKind kind = MapKind::kScans;  ///< a floor plan serves localisation alone
  Floors floors;                   ///< that a lost robot is searched in as well; no part of the stored map

  /// The keyframes' scans are shared.
  MapState clone() const;
};

/// Where a FrontEnd begins in a stored map; in one without keyframes, at a new map's origin.
FrontEndStart startIn(const MapState& map, std::int32_t map_id = 0);

/// The keyframes of a stored map for the Mapper; those that its grid does not show yet are the last ones.
std::vector<MapScan> scansOf(const MapState& map);
/// Its depth views, where their keyframes are now.
std::vector<MapView> viewsOf(const MapState& map);

/// What its edits ask of the drawing.
EditedDrawing drawingOf(const MapState& map);
/// A keyframe's scan before anything was erased of it.
const StoredScan& wholeScan(const MapState& map, int id);
/// A grid in which all keyframes and views of a map are drawn, as its edits ask.
/// @param progress is called with the share [1] of the keyframes that is drawn
OccupancyGrid drawGrid(const MapState& map, const OccupancyGridConfig& config,
                       const std::function<void(double)>& progress = {});

/// Why a robot cannot go on in a map, in words: its lidar is elsewhere than when the map was made, or the map cannot be
/// extended. Empty: it can.
std::string misfitOf(const MapState& map, const LidarModel& lidar, bool localise_only);

}  // namespace slam
