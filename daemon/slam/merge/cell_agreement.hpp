// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>

#include "mapping/occupancy_grid.hpp"

namespace slam {

/// How the occupied cells of two grids agree where both have seen something.
struct CellAgreement {
  int same = 0;       ///< [cells] occupied in one grid, and in the other one within the tolerance
  int different = 0;  ///< [cells] occupied in one grid, and free all around in the other one

  double share() const { return static_cast<double>(same) / std::max(1, same + different); }
};

/// Compares two grids of one frame and one cell size, each one's occupied cells with the other. @param tolerance [m]
CellAgreement compareCells(const OccupancyGrid& a, const OccupancyGrid& b, double tolerance);

}  // namespace slam
