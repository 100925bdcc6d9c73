// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "core/pose2.hpp"
#include "mapping/map_image.hpp"
#include "tools/sim/world.hpp"

namespace slam::sim {

/// What a perfect map of a height band would hold, over the area that the robot could have seen.
class TruthMap {
 public:
  /// @param bottom, top [m] height band
  TruthMap(const World& world, double bottom, double top, double resolution = 0.05);

  /// The robot looked along this ray up to `range` [m].
  void see(const Eigen::Vector2d& from, double direction, double range);

  /// Occupied: something stands in the band and it was looked at; free: looked through and nothing stands there.
  MapImage image() const;

 private:
  const World& world_;
  double bottom_, top_;
  MapImage image_;  // cells: kFree where something was looked through or at
};

}  // namespace slam::sim
