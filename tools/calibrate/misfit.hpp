// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "tools/calibrate/wheel_model.hpp"

namespace slam {

/// Lidar's motion minus the wheels' for a geometry: x, y, theta [m, m, rad].
Eigen::Vector3d residual(const RobotGeometry& geometry, const LidarMotion& motion);

/// Squared residual of a motion against its covariance.
struct Misfit {
  double translation = 0.0, rotation = 0.0;  ///< [1] chi-square of 2 and of 1 degree of freedom
  double all = 0.0;                          ///< [1] of 3
};
std::vector<Misfit> misfits(const RobotGeometry& geometry, std::span<const LidarMotion> motions);

/// Of Misfit::all.
double medianMisfit(std::span<const Misfit> misfits);

/// How much larger the residuals are than the motions' covariances say. Never less than 1: a calibration is not surer
/// than its motions claim.
struct NoiseScale {
  double translation = 1.0, rotation = 1.0;  ///< [1] of sigmas
};

/// From the medians: what up to half of the motions do beyond them does not matter.
NoiseScale robustScale(std::span<const Misfit> misfits);
/// From the sums, for a geometry that was fitted to these motions.
NoiseScale fittedScale(std::span<const Misfit> misfits);

/// The motions with their covariances scaled.
std::vector<LidarMotion> scaled(std::vector<LidarMotion> motions, const NoiseScale& scale);

}  // namespace slam
