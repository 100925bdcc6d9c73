// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "core/pose2.hpp"
#include "mapping/map_image.hpp"

namespace slam {

struct PrecisionRecall {
  double precision = 0.0, recall = 0.0, f1 = 0.0;  ///< [1]
};

/// A map against the truth, over the truth's cells that are known; occupied cells with a tolerance of one cell.
struct MapErrors {
  PrecisionRecall occupied, free;
  int compared = 0;              ///< cells of the truth that are known
  double completeness = 0.0;     ///< [1] share of them that the map knows
  double false_obstacles = 0.0;  ///< [1] share of the truth's free cells, one cell or more from any obstacle, that the
                                 ///< map calls occupied
};

/// @param T_truth_map where the map lies in the truth's frame
MapErrors compareMaps(const MapImage& map, const MapImage& truth, const Pose2& T_truth_map = {});

}  // namespace slam
