// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <vector>

namespace slam {

/// One point of a deskewed scan, in base at one instant: as deskew() leaves it, at the scan's stamp.
struct ScanPoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< [m]
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();    ///< unit, towards the lidar; zero where no line was found
  double normal_variance = 0.0;                        ///< [rad^2] of the normal's direction
  double range = 0.0;                                  ///< [m] from the lidar, as measured
  /// It goes on a row of nearer points: the next spot that a beam hit on a wall seen too flat for a line to be fitted.
  /// Such a spot moves along the wall as the robot does.
  bool grazing = false;

  bool hasNormal() const { return normal != Eigen::Vector2d::Zero(); }
};

/// Points in acquisition order. Reserve LaserScan::kCapacity once and it never allocates again.
using ScanPoints = std::vector<ScanPoint>;

/// Mean distance of the points from the lidar [m]: the lever that makes a rotation comparable with a translation.
inline double meanRange(std::span<const ScanPoint> points) {
  double sum = 0.0;
  for (const ScanPoint& point : points) sum += point.range;
  return points.empty() ? 1.0 : std::max(0.1, sum / static_cast<double>(points.size()));
}

}  // namespace slam
