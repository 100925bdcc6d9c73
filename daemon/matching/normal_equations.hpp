// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>

#include "matching/match_result.hpp"

namespace slam {

/// Sums of a least-squares problem in (x, y, theta), about the scan's own pose.
struct NormalEquations {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();         ///< sum w J^T J [1, m, m^2]
  Eigen::Matrix3d spurious = Eigen::Matrix3d::Zero();  ///< expected part of H that comes from noise in the normals
  Eigen::Vector3d g = Eigen::Vector3d::Zero();         ///< sum w J^T e
  double weight = 0.0;                                 ///< sum w
  double squared_error = 0.0;                          ///< sum w e^2 [m^2]
  int pairs = 0;
};

/// Which directions of (x, y, theta) the equations see, and the step along them.
struct ObservableStep {
  Eigen::Vector3d step = Eigen::Vector3d::Zero();            ///< [m, m, rad]
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();  ///< as in MatchResult
  int observable = 0;
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();  ///< pseudo-inverse of H on the observable directions
  Eigen::Vector3d weakest = Eigen::Vector3d::Zero();  ///< observable direction that is seen least; a metre at the lever
};

/// @param lever [m] mean distance of the points: makes rotation comparable with translation
/// @param most  directions to use at most; the weakest are left out first
ObservableStep solveObservable(const NormalEquations& equations, double lever, double min_information, int most = 3);

}  // namespace slam
