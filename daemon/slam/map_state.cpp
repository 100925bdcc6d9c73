// SPDX-License-Identifier: BSD-3-Clause
#include "slam/map_state.hpp"

#include <cmath>
#include <cstdio>

namespace slam {
namespace {

constexpr double kMaxShift = 0.02;  // [m] of the lidar on the robot
constexpr double kMaxTurn = 0.03;   // [rad]

}  // namespace

MapState MapState::clone() const {
  return {keyframes, in_map,       grid.clone(), views, grid_keyframes, T_map_base, gyro_bias,
          body,      T_base_lidar, range_max,    utime, edits,          kind,       floors};
}

FrontEndStart startIn(const MapState& map, std::int32_t map_id) {
  return {.map_id = map_id,
          .first_keyframe = map.keyframes.size(),
          .in_known_map = map.keyframes.size() > 0,
          .T_map_base = map.T_map_base,
          .body = map.body,
          .gyro_bias = map.gyro_bias};
}

std::vector<MapScan> scansOf(const MapState& map) {
  std::vector<MapScan> scans;
  if (map.kind == MapKind::kFloorPlan) return scans;
  for (int id = 0; id < map.keyframes.size(); ++id) {
    if (map.in_map[static_cast<std::size_t>(id)] == 0) continue;
    scans.push_back({id, map.keyframes.pose(id), map.keyframes.scan(id)});
  }
  return scans;
}

std::vector<MapView> viewsOf(const MapState& map) {
  std::vector<MapView> views = map.views;
  std::erase_if(views, [&](const MapView& view) { return map.in_map[static_cast<std::size_t>(view.keyframe)] == 0; });
  for (MapView& view : views) view.T_map_keyframe = map.keyframes.pose(view.keyframe);
  return views;
}

EditedDrawing drawingOf(const MapState& map) { return drawingOf(map.edits, map.keyframes, map.in_map); }

const StoredScan& wholeScan(const MapState& map, int id) {
  const auto whole = map.edits.whole.find(id);
  return whole == map.edits.whole.end() ? *map.keyframes.scan(id) : *whole->second;
}

OccupancyGrid drawGrid(const MapState& map, const OccupancyGridConfig& config,
                       const std::function<void(double)>& progress) {
  OccupancyGrid grid(config);
  const EditedDrawing edits = drawingOf(map);
  for (int id = 0; id < map.keyframes.size(); ++id) {
    const StoredScan& scan = *map.keyframes.scan(id);
    if (map.in_map[static_cast<std::size_t>(id)] != 0) grid.add(map.keyframes.pose(id), scan.T_base_lidar, scan.points);
    if (progress) progress((id + 1.0) / map.keyframes.size());
  }
  for (const MapView& view : viewsOf(map))
    grid.add(view.T_map_base() * view.view->T_base_depth, *shownOf(view, edits.erased));
  FreeCells free(edits.free, grid.resolution());
  grid.tiles().forEachTile([&](TileIndex tile, const auto&) { free.apply(grid, {&tile, 1}); });
  return grid;
}

std::string misfitOf(const MapState& map, const LidarModel& lidar, bool localise_only) {
  if (map.kind == MapKind::kFloorPlan) {
    return localise_only ? "" : "a picture of a map cannot be extended; set mode to \"localise\"";
  }
  if (map.keyframes.size() == 0) return "";
  const Pose2 gap = between(map.T_base_lidar, lidar.T_base_lidar);
  if (std::hypot(gap.x, gap.y) < kMaxShift && std::abs(gap.theta) < kMaxTurn) return "";
  char text[200];
  std::snprintf(text, sizeof text,
                "was made with the lidar at x %.3f m, y %.3f m, yaw %.3f rad, the configuration says %.3f, %.3f, %.3f; "
                "fix [lidar], or begin a new map",
                map.T_base_lidar.x, map.T_base_lidar.y, map.T_base_lidar.theta, lidar.T_base_lidar.x,
                lidar.T_base_lidar.y, lidar.T_base_lidar.theta);
  return text;
}

}  // namespace slam
