// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>

#include "core/pose2.hpp"
#include "core/pose_covariance.hpp"
#include "core/timestamp.hpp"

namespace slam {

constexpr double kStandardGravity = 9.80665;  ///< [m/s^2] of one g

/// What the wheels alone say: the pose they have dead-reckoned so far. Only differences between samples are used, so a
/// lost sample loses nothing, and the origin is arbitrary. Any base (differential, omni, mecanum) can give it.
struct WheelSample {
  Timestamp stamp;              ///< when the wheels stood at these angles
  Pose2 T_wheels_base;          ///< base in a frame that starts anywhere and drifts
  bool turn_rate_known = true;  ///< false: the source measures speed only, theta of T_wheels_base says nothing
  bool restarted = false;       ///< the source began anew: what was driven since the sample before is not known
  bool lifted = false;          ///< a wheel hangs in the air: T_wheels_base stands, and the robot may be carried
};

/// One reading of the inertial unit, in base axes (x forward, y left, z up).
struct ImuSample {
  Timestamp stamp;
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< [rad/s], counter-clockwise about each axis
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< specific force [m/s^2]: (0, 0, +9.81) at rest; 0: not measured
  bool rate_known = true;  ///< false: the gyro is at the end of its range, or not to be believed
};

/// What is known of the bias of the gyro's z axis: its reading at rest.
struct GyroBias {
  double value = 0.0;     ///< [rad/s]
  double variance = 0.0;  ///< [rad^2/s^2]
};

/// A pose measured from outside, e.g. by matching a scan, that may be blind in some directions.
struct PoseMeasurement {
  Timestamp stamp;
  Pose2 T_map_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();      ///< of (x, y, theta) in map [m, m, rad]
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();  ///< columns: unit directions of (x, y, theta); the first
                                                             ///< `observable` of them were measured
  Sensitivity sensitivity = Sensitivity::Zero();             ///< of T_map_base, as far as it was measured
  int observable = 3;                                        ///< 0..3
  bool bypass_gate = false;  ///< nothing else around fits as well: a contradiction is the prediction's fault, not its
};

}  // namespace slam
