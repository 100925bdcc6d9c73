// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/pose2.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// What a consumer may do with a pose.
enum class LocalisationState : std::uint8_t {
  kInitialising,  ///< no scan has been placed yet
  kLocalised,     ///< the newest scan was matched
  kDegraded,      ///< the pose is carried on by wheels and IMU, or by the scans without them,
                  ///< or may be one in another of several maps
  kLost,          ///< the pose is not valid
};
inline const char* nameOf(LocalisationState state) {
  constexpr const char* kNames[] = {"initialising", "localised", "degraded", "lost"};
  return kNames[static_cast<std::size_t>(state)];
}

/// Velocity of base in its own axes.
struct Twist2 {
  double vx = 0.0;     ///< [m/s] forward
  double vy = 0.0;     ///< [m/s] left
  double omega = 0.0;  ///< [rad/s] counter-clockwise
};

/// The greatest speeds at which slamd drives a base, whoever asks for more.
struct SpeedLimits {
  double max_speed = 1.0;      ///< [m/s] of the turning centre, in any direction: a brisk walk, stopped within 0.5 m
  double max_turn_rate = 2.0;  ///< [rad/s] a turn in 3 s

  /// What is asked for [1], so that its curve stays: all of it is made slower by one factor, which is at most 1.
  double factor(const Twist2& twist) const {
    double factor = 1.0;
    const double speed = std::hypot(twist.vx, twist.vy), turn_rate = std::abs(twist.omega);
    if (speed > max_speed) factor = max_speed / speed;
    if (turn_rate > max_turn_rate) factor = std::min(factor, max_turn_rate / turn_rate);
    return factor;
  }

  void visitSettings(auto& v) {
    v.site("max_speed", max_speed, "m/s", 0.01, 10.0,
           "The base is driven at most this fast; a SLAM_DRIVE that asks for more is made slower on the same curve.",
           "Set it to the speed from which the robot stops within the room that it has.");
    v.site("max_turn_rate", max_turn_rate, "rad/s", 0.01, 20.0,
           "The base is turned at most this fast; a SLAM_DRIVE that asks for more is made slower on the same curve.",
           "Set it to the turn rate at which the robot harms nobody beside it.");
  }
};

/// Pose of base in map.
struct PoseEstimate {
  Timestamp stamp;
  Pose2 T_map_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta) in map [m, m, rad]
  Twist2 twist;
  LocalisationState state = LocalisationState::kInitialising;
  double match_quality = 0.0;  ///< share of the newest scan's points that met the reference, 0..1
};

/// Fused wheels and IMU, without the lidar: smooth, drifting, never jumps.
struct OdometryEstimate {
  Timestamp stamp;
  Pose2 T_odom_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta) in odom [m, m, rad]
  Twist2 twist;
  double gyro_bias = 0.0;  ///< [rad/s] reading of the gyro's z axis at rest
  bool slip = false;       ///< wheels contradict the gyro
  bool standstill = false;
  Pose2 T_map_odom;  ///< joins the two: T_map_base = T_map_odom * T_odom_base
};

}  // namespace slam
