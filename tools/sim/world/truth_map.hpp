// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "core/pose2.hpp"
#include "mapping/map_image.hpp"
#include "tools/sim/world/world.hpp"

namespace slam::sim {

struct HeightBand {
  double bottom = 0.0, top = 0.0;  ///< [m] above the floor
};

/// What a perfect map of a height band would hold, over the area that the robot could have seen.
class TruthMap {
 public:
  /// @param scanned the plane of seeRay(), within `band`
  TruthMap(const World& world, const HeightBand& band, const HeightBand& scanned, double resolution = 0.05);

  /// A sensor looked along this level ray, in the scanned plane, up to a surface at `range` [m].
  void seeRay(const Eigen::Vector2d& from, double direction, double range);
  /// A sensor saw a surface of the band at `p`. @param direction of the look, any length
  void seeSurface(const Eigen::Vector2d& p, const Eigen::Vector2d& direction);
  /// A sensor saw the floor at `p`.
  void seeFloor(const Eigen::Vector2d& p);

  /// Occupied: something stands in the band and a sensor met it; free: looked through and nothing stands there; a cell
  /// under something that the scanned plane does not meet stays unknown.
  MapImage image() const;

 private:
  static constexpr std::uint8_t kPassed = 1, kMet = 2;

  void mark(const Eigen::Vector2d& p, std::uint8_t what);

  const World& world_;
  HeightBand band_, scanned_;
  MapImage seen_;  // cells: kPassed and kMet
};

}  // namespace slam::sim
