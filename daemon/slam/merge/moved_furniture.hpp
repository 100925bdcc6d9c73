// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "mapping/occupancy_grid.hpp"
#include "slam/merge/compared_map.hpp"

namespace slam {

struct MovedFurnitureConfig {
  ComparedMapConfig compared;
  double cell = 0.025;          ///< [m] of the grids: furniture differs by centimetres
  double distance = 1.2;        ///< [m] by which a piece may have been moved, ...
  double turn = 0.17;           ///< [rad] ... turned by any multiple of this
  double step = 0.05;           ///< [m] between two places that are tried
  double min_recognised = 0.5;  ///< [1] of a piece's cells that its twin has, at least ...
  double max_missed = 0.05;     ///< [1] ... and of those that the other map has seen, which it may lack
  double turned_weight = 0.5;   ///< [1] of outline that was turned: of so many places one fits by chance
  /// [1] of outline without a twin. Of two floors up to 0.42 of the outline has one, of one floor 0.48 or more; with
  /// 0.43 the evidence is 0 m.
  double other_weight = 0.75;
};

/// What stands in one of two maps alone [m of outline, both maps together].
struct MovedFurniture {
  double moved = 0.0;   ///< of pieces that stand near by in the other map
  double turned = 0.0;  ///< of those that stand there turned
  double other = 0.0;   ///< of all others

  /// [m] for one floor rather than two: moved + turned_weight * turned, less other_weight * all the rest
  double evidence = 0.0;

  double found() const { return moved + turned; }
};

/// Compares the shapes of what stands in one map alone. Furniture that was moved keeps its shape: a piece that is gone
/// is near by, as far as the other map has seen it. Of other furniture few pieces have a twin, by chance.
/// @param a, b of one frame, with cells of config.cell
MovedFurniture findMovedFurniture(const OccupancyGrid& a, const OccupancyGrid& b,
                                  const MovedFurnitureConfig& config = {});

}  // namespace slam
