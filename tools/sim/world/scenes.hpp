// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/pose2.hpp"
#include "tools/sim/world/world.hpp"

namespace slam::sim {

/// A place to drive to in a straight line, turning on the spot before and after.
struct Waypoint {
  Pose2 pose;             ///< in world; the robot stops with this heading ...
  bool stop = true;       ///< ... or passes through without turning to it
  double pause = 1.0;     ///< [s] standing there
  bool measured = false;  ///< accuracy is reported here
};

/// A world and a drive through it. The robot starts at the origin, so world and map coincide.
struct Scene {
  std::string name;
  World world = {};
  std::vector<Waypoint> route = {};
  double speed = 0.2;         ///< [m/s]
  double turn_rate = 0.5236;  ///< [rad/s] on the spot
  double settle = 2.0;        ///< [s] standing before the drive
};

/// What can be asked of a scene besides its seed.
struct SceneVariant {
  int furniture_moved = 0;  ///< of homes: 0 where it first stood; any other number, 0.5 to 1 m from there
  int floor = 0;            ///< of homes: the same walls with other furniture, one above the other
  /// Of homes: a lift at the corridor's end takes the robot to this floor; kOpenLift: it stands there and stays open.
  std::optional<int> lift = {};
  static constexpr int kOpenLift = 0;
  int blocks = 4;  ///< of streets, along each side of the grid
  int laps = 1;    ///< of a route that ends where it starts

  friend bool operator==(const SceneVariant&, const SceneVariant&) = default;
};

std::vector<std::string> sceneNames();

/// @param seed places what a scene leaves to chance
/// @throws std::invalid_argument naming the known scenes, or a variant that the scene does not have
Scene makeScene(const std::string& name, std::uint64_t seed, const SceneVariant& variant = {});

}  // namespace slam::sim
