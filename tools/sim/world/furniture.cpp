// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/furniture.hpp"

#include <cmath>

namespace slam::sim {

void addRoom(World& world, double left, double bottom, double right, double top) {
  world.addWall({left, bottom}, {right, bottom});
  world.addWall({right, bottom}, {right, top});
  world.addWall({right, top}, {left, top});
  world.addWall({left, top}, {left, bottom});
}

void addTable(World& world, double x, double y, double length, double width) {
  world.add(Box{x, y, 0.0, length, width, 0.70, 0.74});
  for (const double dx : {-1.0, 1.0}) {
    for (const double dy : {-1.0, 1.0}) {
      world.add(Cylinder{x + dx * (length / 2 - 0.05), y + dy * (width / 2 - 0.05), 0.025, 0.0, 0.70});
    }
  }
}

void addColumnTable(World& world, double x, double y, double length, double width) {
  world.add(Box{x, y, 0.0, length, width, 0.70, 0.74});
  world.add(Cylinder{x, y, 0.05, 0.0, 0.70});
  world.add(Cylinder{x, y, 0.25, 0.0, 0.03});
}

Solids chair(double x, double y) {
  Solids solids{.boxes = {{x, y, 0.0, 0.42, 0.42, 0.43, 0.47}}};
  for (const double dx : {-0.18, 0.18}) {
    for (const double dy : {-0.18, 0.18}) solids.cylinders.push_back({x + dx, y + dy, 0.015, 0.0, 0.43});
  }
  return solids;
}

void addTruck(World& world, double x, double y, double yaw) {
  constexpr double kLength = 2.2, kWidth = 1.0;
  world.add(Box{x, y, yaw, kLength, kWidth, 0.35, 1.2});
  const double c = std::cos(yaw), s = std::sin(yaw);
  for (const double along : {-0.7, 0.7}) {
    for (const double across : {-0.42, 0.42}) {
      world.add(Box{x + c * along - s * across, y + s * along + c * across, yaw, 0.40, 0.14, 0.0, 0.40});
    }
  }
}

}  // namespace slam::sim
