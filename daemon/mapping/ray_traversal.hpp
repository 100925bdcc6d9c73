// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdlib>

#include "core/tiled_grid.hpp"

namespace slam {

/// Calls visit(CellIndex) for each cell on the line from `from` (included) to `to` (excluded), in order, by Bresenham's
/// integer algorithm: the same cells on every machine.
template <typename Visit>
void traverseRay(CellIndex from, CellIndex to, Visit&& visit) {
  const int dx = std::abs(to.column - from.column), dy = -std::abs(to.row - from.row);
  const int step_x = from.column < to.column ? 1 : -1, step_y = from.row < to.row ? 1 : -1;
  int error = dx + dy;
  while (from != to) {
    visit(from);
    const int doubled = 2 * error;
    if (doubled >= dy) {
      error += dy;
      from.column += step_x;
    }
    if (doubled <= dx) {
      error += dx;
      from.row += step_y;
    }
  }
}

}  // namespace slam
