// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/pose2.hpp"

namespace slam {

/// What is calibrated: the wheels of a differential base, and where its lidar sits.
struct RobotGeometry {
  double left_radius = 0.0325;   ///< r_L [m]
  double right_radius = 0.0325;  ///< r_R [m]
  double track = 0.2015;         ///< b [m] between the wheels' contact points
  Pose2 T_base_lidar;            ///< l

  using Vector = Eigen::Matrix<double, 6, 1>;
  enum Index { kLeftRadius, kRightRadius, kTrack, kLidarX, kLidarY, kLidarYaw };

  Vector vector() const {
    return {left_radius, right_radius, track, T_base_lidar.x, T_base_lidar.y, T_base_lidar.theta};
  }
  static RobotGeometry fromVector(const Vector& v) { return {v[0], v[1], v[2], Pose2::fromVector(v.tail<3>())}; }
};

/// How far the wheels turned in one step between two readings [rad], positive driving forward. Steps are short: within
/// one the base runs on an arc.
struct WheelStep {
  double left = 0.0, right = 0.0;
};

/// One motion of the robot as its lidar and its wheels saw it, over exactly the same time.
struct LidarMotion {
  Pose2 T_begin_end;                                     ///< s: lidar at the end in the lidar's frame at the beginning
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of T_begin_end (x, y, theta) [m, m, rad]
  std::vector<WheelStep> wheels;
};

/// T_begin_end of the lidar that a geometry predicts from the wheels, and its derivative by RobotGeometry::vector().
struct PredictedMotion {
  Pose2 T_begin_end;
  Eigen::Matrix<double, 3, 6> jacobian;
};

/// The measurement function of [Censi 2013], s = l^-1 * r * l, where r is the base's motion by dead reckoning.
///
/// [Censi 2013] A. Censi, A. Franchi, L. Marchionni, G. Oriolo, "Simultaneous calibration of odometry and sensor
/// parameters for mobile robots", IEEE Transactions on Robotics 29(2).
Pose2 predictPose(const RobotGeometry& geometry, std::span<const WheelStep> wheels);
PredictedMotion predictMotion(const RobotGeometry& geometry, std::span<const WheelStep> wheels);

}  // namespace slam
