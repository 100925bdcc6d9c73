// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cmath>
#include <span>

#include "tools/calibrate/observability.hpp"
#include "tools/calibrate/wheel_model.hpp"

namespace slam {

struct CalibrationConfig {
  int min_motions = 10;  ///< fewer are refused
  double gate = 16.27;   ///< [1] chi-square of a motion's residual, 3 degrees of freedom, beyond which it is an outlier
  double min_kept = 0.5;  ///< [1] share of the motions that must agree
};

enum class CalibrationStatus {
  kDone,
  kPartly,        ///< some parameters are not determined: see Calibration::determined
  kTooFew,        ///< motions
  kContradicted,  ///< no geometry fits most of the motions, or none those that would determine it
};

struct Calibration {
  CalibrationStatus status = CalibrationStatus::kTooFew;
  RobotGeometry geometry;                 ///< where not determined, as near to the configured one as the data allow
  Observability::Matrix covariance = {};  ///< of geometry.vector()
  std::array<bool, 6> determined = {};    ///< by RobotGeometry::Index
  DriveKind drive = DriveKind::kVaried;   ///< of the motions used
  int used = 0, rejected = 0;             ///< motions
  double translation_residual = 0.0;      ///< [m] RMS over the motions used
  double rotation_residual = 0.0;         ///< [rad] RMS
  double translation_noise = 1.0;         ///< [1] residuals against the sigmas that came with the motions
  double rotation_noise = 1.0;            ///< [1]

  double sigma(RobotGeometry::Index i) const { return std::sqrt(covariance(i, i)); }
};

/// Simultaneous calibration of wheels and lidar by maximum likelihood [Censi 2013] (see wheel_model.hpp): the geometry
/// that makes  sum_k || s_k - s(geometry, wheels_k) ||^2  least, weighted by the motions' covariances.
///
/// The closed form (closed_form.hpp) starts Gauss-Newton steps with the full covariances. As in the paper, motions that
/// fit worst (slip, a wrong match) are discarded and all is estimated anew until nothing changes. The paper discards a
/// fixed share; slip on a real floor can spoil a third, so here it is what lies beyond a gate, against the noise that
/// the better half shows, and the first estimate already is one that half of the motions agree on.
///
/// The covariance is the inverse of the Fisher information, for the noise that the residuals show in translation and in
/// rotation, or that the motions claim where that is more. What the information does not determine stays as configured
/// and is marked.
///
/// @param configured  the geometry believed so far: starts the estimate where the closed form is singular
Calibration calibrate(std::span<const LidarMotion> motions, const RobotGeometry& configured,
                      const CalibrationConfig& config = {});

}  // namespace slam
