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
    // All ones where the step goes along the axis: nobody can guess the branches that this spares.
    const int along_x = -static_cast<int>(2 * error >= dy), along_y = -static_cast<int>(2 * error <= dx);
    error += (dy & along_x) + (dx & along_y);
    from.column += step_x & along_x;
    from.row += step_y & along_y;
  }
}

}  // namespace slam
