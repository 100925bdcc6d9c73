// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <numbers>
#include <optional>

#include "tools/sim/world/scenes.hpp"

namespace slam::sim {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180.0;

/// The paper's Table I: a rectangle of 1.3 m x 3.25 m along floor tiles, in a room with some furniture.
Scene tileRectangle();

/// The paper's Fig. 9 and Table III: about 70 m^2 with a row of conference tables, driven clockwise. Its headings are
/// given there without sign; turning clockwise makes them negative.
Scene meetingRoom();

/// A corridor 2 m wide around a block: 124 m, with door recesses and pillars at irregular distances.
Scene corridorLoop(std::uint64_t seed);

/// A floor of offices, 80 m by 40 m: corridors 2.4 m wide around two blocks, with doors at irregular distances, of
/// which a third stand open to furnished rooms. Driven around both, then along the corridor between them: 360 m.
Scene officeFloor(std::uint64_t seed);

/// The paper's Fig. 7: desks, T-shaped tables, a truck and solid spheres; a lap around and between them.
Scene gazebo();

/// A furnished room in which persons walk through the view and leave, and a chair is moved; the robot looks at their
/// places again.
Scene people();

/// A home of 12 x 8 m: a corridor, rooms on both sides of it with open doors, furniture. Driven through every room.
/// @param furniture_moved see SceneVariant
Scene home(int furniture_moved);

/// One of eight homes of various sizes: seeds 1 to 8, again 9 to 16, and so on.
/// @param floor, lift see SceneVariant
Scene homes(std::uint64_t seed, int furniture_moved, int floor = 0, const std::optional<int>& lift = {});

/// A hall of 40 x 30 m with pillars and some shelves.
Scene hall(std::uint64_t seed);

/// A corridor 2 m wide with nothing in it. @param length [m]
Scene bareCorridor(double length);

/// Streets 6 m wide around equal blocks of 24 x 16 m, whose fronts have niches where the seed puts them. Driven at
/// 1 m/s from crossing to crossing, as the seed decides. @param blocks along each side of the grid
Scene streets(std::uint64_t seed, int blocks);

/// Two rooms, a doorway and its door leaf, which stands open.
Scene openDoor();

}  // namespace slam::sim
