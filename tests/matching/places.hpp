// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "core/scan.hpp"
#include "matching/deskew.hpp"
#include "matching/normals.hpp"
#include "support/simulated/lidar.hpp"
#include "tools/sim/world/world.hpp"

namespace slam::test {

/// Somewhere to scan, the same at every height.
struct Place {
  const char* name = "";
  Eigen::Vector2d low, high;  ///< [m] corners of the area that poses are drawn from
  double reach = 12.0;        ///< [m] of the lidar
  sim::World world = {};

  bool free(const Pose2& pose) const { return !world.occupied(pose.translation(), 0.1, 0.3, 0.25); }

  /// A free pose anywhere in the area.
  Pose2 draw(std::mt19937& random) const {
    std::uniform_real_distribution<double> x(low.x(), high.x()), y(low.y(), high.y());
    std::uniform_real_distribution<double> heading(-std::numbers::pi, std::numbers::pi);
    while (true) {
      const double px = x(random), py = y(random);
      const Pose2 pose{px, py, heading(random)};
      if (free(pose)) return pose;
    }
  }

  /// A free pose near another. @param translation [m], rotation [rad] at most, each coordinate
  Pose2 drawNear(const Pose2& pose, double translation, double rotation, std::mt19937& random) const {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    while (true) {
      const double dx = translation * unit(random), dy = translation * unit(random);
      const Pose2 near{pose.x + dx, pose.y + dy, wrapAngle(pose.theta + rotation * unit(random))};
      if (free(near)) return near;
    }
  }

  /// [m] to what stands there; infinite: nothing within reach
  double range(const Pose2& pose, double bearing) const {
    constexpr double kHeight = 0.2;  // [m]
    const double direction = pose.theta + bearing;
    return world.castRay({pose.x, pose.y, kHeight}, {std::cos(direction), std::sin(direction), 0.0}, reach)
        .value_or(std::numeric_limits<double>::infinity());
  }

  /// Points with normals of one scan of 360 beams taken at rest. @param range_sigma [m]
  ScanPoints scan(const Pose2& pose, double range_sigma, std::mt19937& random) const {
    const SimulatedLidar lidar{.reach = reach, .range_sigma = range_sigma};
    const LaserScan scan = lidar.scan(*this, pose, random);
    ScanPoints points;
    deskew(scan, {0.05F, static_cast<float>(reach)}, scan.stamp, Pose2{}, PoseHistory(2), points);
    estimateNormals(points, Eigen::Vector2d::Zero(), {.range_sigma = range_sigma});
    return points;
  }
};

inline void addWalls(sim::World& world, const std::vector<Eigen::Vector2d>& corners) {
  for (std::size_t i = 0; i < corners.size(); ++i) world.addWall(corners[i], corners[(i + 1) % corners.size()]);
}

inline Place bareRoom() {
  Place place{.name = "Room", .low = {-2.6, -1.6}, .high = {2.6, 1.6}};
  addWalls(place.world, {{-3, -2}, {3, -2}, {3, 2}, {-3, 2}});
  return place;
}

inline Place furnishedRoom() {
  Place place = bareRoom();
  place.name = "FurnishedRoom";
  place.world.add(sim::Box{-2.5, 1.2, 0.0, 0.8, 1.4});  // cupboard
  place.world.add(sim::Box{2.2, -1.3, 0.4, 0.9, 0.5});  // crate, put down askew
  place.world.add(sim::Box{0.3, 1.8, 0.0, 1.6, 0.3});   // radiator
  place.world.add(sim::Cylinder{1.0, 0.6, 0.15});
  place.world.add(sim::Cylinder{-1.2, -1.4, 0.25});
  for (const double x : {-0.6, 0.0}) {
    for (const double y : {-0.5, 0.1}) place.world.add(sim::Cylinder{x, y, 0.025});  // legs of a table
  }
  return place;
}

/// Larger than the lidar's reach: at most poses only some of the walls are seen.
inline Place hallWithPillars() {
  Place place{.name = "Hall", .low = {-11.5, -8.0}, .high = {11.5, 8.0}};
  addWalls(place.world, {{-12.5, -9}, {12.5, -9}, {12.5, 9}, {-12.5, 9}});
  for (const double x : {-7.5, -2.5, 2.5, 7.5}) {
    for (const double y : {-3.5, 3.5}) place.world.add(sim::Box{x, y, 0.0, 0.5, 0.5});
  }
  return place;
}

inline Place bentCorridor() {
  Place place{.name = "BentCorridor", .low = {-0.7, -0.7}, .high = {9.0, 9.0}, .reach = 8.0};
  addWalls(place.world, {{-1, -1}, {14, -1}, {14, 1}, {1, 1}, {1, 14}, {-1, 14}});
  place.world.add(sim::Box{8.0, 8.0, 0.0, 14.0, 14.0});  // what it bends around: no poses in there
  return place;
}

/// Doors 0.9 m wide stand 0.15 m back from the walls, every 3.7 m; the two sides are not in step.
inline Place corridorWithDoors() {
  Place place{.name = "CorridorWithDoors", .low = {-8.0, -0.6}, .high = {8.0, 0.6}, .reach = 8.0};
  addWalls(place.world, {{-30, -1.15}, {30, -1.15}, {30, 1.15}, {-30, 1.15}});
  for (int i = -8; i <= 8; ++i) {
    place.world.add(sim::Box{3.7 * i, 1.075, 0.0, 2.8, 0.15});
    place.world.add(sim::Box{3.7 * i + 1.3, -1.075, 0.0, 2.8, 0.15});
  }
  return place;
}

/// Two bare walls along x.
inline Place endlessCorridor() {
  Place place{.name = "EndlessCorridor", .low = {-5.0, -0.7}, .high = {5.0, 0.7}, .reach = 8.0};
  place.world.add(sim::Box{0.0, 1.1, 0.0, 1e4, 0.2});
  place.world.add(sim::Box{0.0, -1.1, 0.0, 1e4, 0.2});
  return place;
}

}  // namespace slam::test
