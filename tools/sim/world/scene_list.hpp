// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "tools/sim/world/scenes.hpp"

namespace slam::sim {

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

/// Two rooms, a doorway and its door leaf, which stands open.
Scene openDoor();

}  // namespace slam::sim
