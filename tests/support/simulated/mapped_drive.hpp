// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <utility>
#include <vector>

#include "slam/map_state.hpp"
#include "slam/merge/map_merge.hpp"
#include "support/simulated/keyframes.hpp"
#include "support/stored_map.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam::test {

/// The map of a drive, and the true poses of its keyframes.
struct MappedDrive {
  MapState map;
  std::vector<Pose2> truth;
};

inline MappedDrive mapped(const Place& place, std::vector<Pose2> truth, unsigned seed) {
  KeyframeDrive drive(place, seed);
  MappedDrive result;
  for (const Pose2& pose : truth) {
    result.map.keyframes.add(drive.at(pose, {0.002, 0.002, 0.0005}));
    result.map.in_map.push_back(1);
  }
  result.truth = std::move(truth);
  result.map.grid = OccupancyGrid(smallGrid());
  result.map.grid = drawGrid(result.map, smallGrid());
  result.map.grid_keyframes = result.map.keyframes.size();
  result.map.T_map_base = result.map.keyframes.pose(result.map.keyframes.size() - 1);
  result.map.T_base_lidar = {};
  result.map.range_max = place.reach;
  return result;
}

/// A quarter of a metre apart along the middle of ringCorridor().
inline std::vector<Pose2> alongRing(double from, double to) {
  std::vector<Pose2> poses;
  for (double s = from; s <= to; s += 0.25) poses.push_back(onRing(s));
  return poses;
}

/// A simulated home, or another floor of it, and a drive through all of it.
inline MappedDrive home(std::uint64_t number, unsigned seed, int furniture_moved = 0, int floor = 0) {
  const sim::Scene scene = sim::makeScene("homes", number, {.furniture_moved = furniture_moved, .floor = floor});
  const Place place{.name = "Home", .low = {}, .high = {}, .reach = 12.0, .world = scene.world};
  std::vector<Pose2> poses{Pose2{}};
  for (const sim::Waypoint& waypoint : scene.route) {
    const Eigen::Vector2d from = poses.back().translation(), way = waypoint.pose.translation() - from;
    for (double s = 0.3; s < way.norm(); s += 0.3) {
      const Eigen::Vector2d p = from + s / way.norm() * way;
      poses.push_back({p.x(), p.y(), std::atan2(way.y(), way.x())});
    }
  }
  return mapped(place, std::move(poses), seed);
}

inline MergedMap merged(const MapState& first, const MapState& second, bool furniture_moved = false) {
  MergeConfig config;
  config.furniture_moved = furniture_moved;
  return mergeMaps(first, second, BackEndConfig{}, smallGrid(), config);
}

}  // namespace slam::test
