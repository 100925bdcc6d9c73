// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <vector>

#include "core/pose2.hpp"
#include "core/pose_covariance.hpp"

namespace slam {

/// One point of a deskewed scan, in base at one instant: as deskew() leaves it, at the scan's stamp.
struct ScanPoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< [m]
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();    ///< unit, towards the lidar; zero where no line was found
  double normal_variance = 0.0;                        ///< [rad^2] of the normal's direction
  Eigen::Vector2d beam = Eigen::Vector2d::Zero();      ///< unit, from the lidar; zero: no lidar measured it
  double bearing = 0.0;                                ///< [rad] of the beam, counter-clockwise from the lidar's zero
  double range = 0.0;                                  ///< [m] from the lidar, as measured
  /// It goes on a row of nearer points: the next spot that a beam hit on a wall seen too flat for a line to be fitted.
  /// Such a spot moves along the wall as the robot does.
  bool grazing = false;

  bool hasNormal() const { return normal != Eigen::Vector2d::Zero(); }
};

/// How systematic errors of one unit each move a point: a column each.
using PointShift = Eigen::Matrix<double, 2, kSystematic>;

/// Of a point as its beam alone is concerned, in base.
inline PointShift shiftOf(const ScanPoint& point) {
  PointShift shift;
  shift.col(kRangeBias) = point.beam;
  shift.col(kBearingScale) = point.range * point.bearing * Eigen::Vector2d(-point.beam.y(), point.beam.x());
  return shift;
}

/// The same in the frame that the scan lies in, with what the errors do to its pose.
/// @param T_ref_base and its sensitivity, in that frame
inline PointShift shiftOf(const ScanPoint& point, const PointTransform& T_ref_base, const Sensitivity& sensitivity) {
  const Eigen::Vector2d lever = T_ref_base.turned(point.position);
  PointShift shift = shiftOf(point);
  for (int i = 0; i < kSystematic; ++i) shift.col(i) = T_ref_base.turned(shift.col(i));
  return shift + sensitivity.topRows<2>() + Eigen::Vector2d(-lever.y(), lever.x()) * sensitivity.row(2);
}

/// Points in acquisition order. Reserve LaserScan::kCapacity once and it never allocates again.
using ScanPoints = std::vector<ScanPoint>;

/// Mean distance of the points from the lidar [m]: the lever that makes a rotation comparable with a translation.
inline double meanRange(std::span<const ScanPoint> points) {
  double sum = 0.0;
  for (const ScanPoint& point : points) sum += point.range;
  return points.empty() ? 1.0 : std::max(0.1, sum / static_cast<double>(points.size()));
}

}  // namespace slam
