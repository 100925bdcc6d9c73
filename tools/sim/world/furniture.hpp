// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "tools/sim/world/world.hpp"

namespace slam::sim {

/// Four walls around the rectangle whose sides are given [m].
void addRoom(World& world, double left, double bottom, double right, double top);

/// Table on four legs; its top, at 0.70 to 0.74 m, is above the lidar.
void addTable(World& world, double x, double y, double length, double width);

/// T-shaped table: a column on a flat foot, under a top at 0.70 to 0.74 m.
void addColumnTable(World& world, double x, double y, double length, double width);

/// Chair on four legs, its seat at 0.43 to 0.47 m.
Solids chair(double x, double y);

/// Lorry as high as a robot: a body from 0.35 to 1.2 m above four wheels.
void addTruck(World& world, double x, double y, double yaw);

}  // namespace slam::sim
