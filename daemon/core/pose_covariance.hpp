// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/pose2.hpp"

namespace slam {

/// Covariance of (x, y, theta) [m, m, rad] in axes that are turned by `angle` [rad] from those that it is given in:
/// of a vector v_a it becomes that of R(angle) v_a.
inline Eigen::Matrix3d turned(const Eigen::Matrix3d& covariance, double angle) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(angle).toRotationMatrix();
  return R * covariance * R.transpose();
}

/// What an error of frame a is for frame b, which is fixed to it: an error of a's heading moves b sideways.
/// @param covariance of a's pose (x, y, theta), in a's axes [m, m, rad]
/// @return of b's pose, in b's axes
inline Eigen::Matrix3d carried(const Eigen::Matrix3d& covariance, const Pose2& T_a_b) {
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J(0, 2) = -T_a_b.y;
  J(1, 2) = T_a_b.x;
  return turned(J * covariance * J.transpose(), -T_a_b.theta);
}

}  // namespace slam
