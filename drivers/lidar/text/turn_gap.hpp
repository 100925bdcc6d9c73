// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>

namespace slam {

/// A lidar that measures a part of each turn: how many samples it would have taken between the last of one scan and the
/// first of the next, had it gone on measuring.
/// @param passed   [s] between the beginnings of the two, by the unit's clock
/// @param turn     [s] @param per_turn samples, of a whole one @param beams that it takes of them
inline int samplesBetween(double passed, double turn, int per_turn, int beams) {
  constexpr double kMostTurns = 100.0;  // missing ones; what is more is another clock
  const double turns = std::round(passed / turn);
  return static_cast<int>(turns > kMostTurns ? 1.0 : std::max(1.0, turns)) * per_turn - beams;
}

}  // namespace slam
