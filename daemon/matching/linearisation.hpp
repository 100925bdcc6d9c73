// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <span>

#include "matching/match_result.hpp"
#include "matching/normal_equations.hpp"
#include "matching/reference.hpp"
#include "matching/scan_points.hpp"

namespace slam {

/// What a scan's points and their partners say at one pose: sums over the pairs of eq. (6), see matchPointToLine().
struct Linearisation {
  NormalEquations equations;
  int covered = 0;              ///< points in the reference's window
  int known = 0;                ///< pairs that agree with a well-known surfel
  int agreeing = 0;             ///< pairs within overlap_distance of their line or point
  double agreeing_error = 0.0;  ///< [m^2] sum of their squared residuals
};

/// @param gate         [m] on the distance of a pair
/// @param kernel_scale [m] residual at which a pair has lost half its weight
Linearisation linearise(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T_ref_base,
                        double gate, double kernel_scale, const MatchConfig& config);

/// Sum over the parts of a scan, points in a row that one wall or body gives, of g g^T, where g is a part's gradient
/// sum w J^T e: the middle of a cluster-robust ("sandwich") covariance [Liang 1986].
Eigen::Matrix3d pullsOfParts(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T_ref_base,
                             const MatchConfig& config);

}  // namespace slam
