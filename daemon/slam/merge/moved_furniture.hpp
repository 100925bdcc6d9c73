// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "mapping/occupancy_grid.hpp"
#include "slam/merge/compared_map.hpp"

namespace slam {

struct MovedFurnitureConfig {
  ComparedMapConfig compared;
  double cell = 0.025;          ///< [m] of the grids: furniture differs by centimetres
  double way = 1.2;             ///< [m] by which a piece may have been moved, ...
  double turn = 0.17;           ///< [rad] ... turned by any multiple of this
  double step = 0.05;           ///< [m] between two places that are tried
  double min_recognised = 0.5;  ///< [1] of a piece's cells that its twin has, at least ...
  double max_missed = 0.05;     ///< [1] ... and of those that the other map has seen, which it may lack
};

/// What stands in one of two maps alone [m of outline, both maps together].
struct MovedFurniture {
  double moved = 0.0;   ///< of pieces that stand near by in the other map
  double turned = 0.0;  ///< of those that stand there turned
  double other = 0.0;   ///< of all others

  double found() const { return moved + turned; }
  /// [m] for one floor rather than two. Twins are found by chance, too: of two floors up to 0.39 of the outline has
  /// one, of one floor 0.48 or more, and 0.43 is an evidence of 0 m. A turned twin has more places, and counts half.
  double evidence() const { return moved + 0.5 * turned - kOtherWeight * (other + 0.5 * turned); }
  static constexpr double kOtherWeight = 0.75;  ///< [1] of outline without a twin
};

/// Compares the shapes of what stands in one map alone. Furniture that was moved keeps its shape: a piece that is gone
/// is near by, as far as the other map has seen it. Of other furniture few pieces have a twin, by chance.
/// @param a, b of one frame, with cells of config.cell
MovedFurniture findMovedFurniture(const OccupancyGrid& a, const OccupancyGrid& b,
                                  const MovedFurnitureConfig& config = {});

}  // namespace slam
