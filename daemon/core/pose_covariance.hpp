// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/pose2.hpp"

namespace slam {

/// Errors that are the same in each scan, so that no mean over scans lessens them: all ranges too long by [m], and all
/// bearings, from the lidar's zero direction, too wide by a share [1].
enum Systematic { kRangeBias, kBearingScale, kSystematic };
/// How such errors, of one unit each, move a pose (x, y, theta) [m, m, rad]: a column each.
using Sensitivity = Eigen::Matrix<double, 3, kSystematic>;

/// Turns vectors of (x, y, theta) by `angle` [rad]: x and y, while theta stays.
inline Eigen::Matrix3d turning(double angle) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(angle).toRotationMatrix();
  return R;
}

/// Covariance of (x, y, theta) [m, m, rad] in axes that are turned by `angle` [rad] from those that it is given in:
/// of a vector v_a it becomes that of R(angle) v_a.
inline Eigen::Matrix3d rotated(const Eigen::Matrix3d& covariance, double angle) {
  const Eigen::Matrix3d R = turning(angle);
  return R * covariance * R.transpose();
}

/// Takes a small error of frame a's pose, in a's axes, to that of b's, which is fixed to it, in b's axes: the adjoint
/// of T_b_a.
inline Eigen::Matrix3d carrying(const Pose2& T_a_b) {
  const double c = std::cos(T_a_b.theta), s = std::sin(T_a_b.theta);
  Eigen::Matrix3d Ad;
  Ad << c, s, s * T_a_b.x - c * T_a_b.y, -s, c, c * T_a_b.x + s * T_a_b.y, 0.0, 0.0, 1.0;
  return Ad;
}

/// What an error of frame a is for frame b, which is fixed to it: an error of a's heading moves b sideways.
/// @param covariance of a's pose (x, y, theta), in a's axes [m, m, rad]
/// @return of b's pose, in b's axes
inline Eigen::Matrix3d carried(const Eigen::Matrix3d& covariance, const Pose2& T_a_b) {
  const Eigen::Matrix3d Ad = carrying(T_a_b);
  return Ad * covariance * Ad.transpose();
}

}  // namespace slam
