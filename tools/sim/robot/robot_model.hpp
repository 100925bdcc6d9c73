// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <random>

#include "core/estimates.hpp"
#include "core/pose2.hpp"
#include "core/timestamp.hpp"
#include "estimation/wheel_odometry.hpp"

namespace slam::sim {

/// Errors of the simulated robot; what a seed draws from.
struct RobotErrors {
  double wheel_radius = 0.01;    ///< [1] relative, each wheel
  double track = 0.01;           ///< [1] relative
  double slip_interval = 25.0;   ///< [s] mean time between slips of one wheel while driving
  double slip_time = 0.3;        ///< [s] of one slip
  double slip_factor = 0.5;      ///< [1] a slipping wheel turns faster by this share
  double gyro_noise = 0.0015;    ///< [rad/s] of one reading (0.005 deg/s/sqrt(Hz), 50 Hz, and vibration)
  double gyro_bias = 0.015;      ///< [rad/s] at start
  double gyro_bias_walk = 2e-5;  ///< [rad/s per sqrt(s)] an MPU6050 at constant temperature
  double gyro_scale = 0.005;     ///< [1] relative
  double accel_noise = 0.05;     ///< [m/s^2]
};

/// Geometry that the odometry believes in (the HandsFree "stone v3"), and its encoders.
inline constexpr DifferentialBase kNominalBase{.wheel_radius = 0.03296, .half_track = 0.1592};
inline constexpr double kCountsPerTurn = 1560.0;

struct ImuReading {
  std::array<double, 3> gyro{};   ///< [rad/s]
  std::array<double, 3> accel{};  ///< [m/s^2]
};

/// What the odometry's beliefs are off from.
struct TrueBase {
  double left_radius, right_radius, half_track;  ///< [m]
};

/// Differential drive with imperfect wheels and an imperfect gyro.
class RobotModel {
 public:
  /// @param nominal geometry that its odometry is given
  RobotModel(const RobotErrors& errors, std::uint64_t seed, const DifferentialBase& nominal = kNominalBase);

  /// Moves the robot with the commanded twist for dt [s].
  void step(const Twist2& command, double dt);
  /// Someone who carries the robot brings it to this pose in dt [s]; its wheels hang still.
  void carry(const Pose2& T_world_base, double dt);

  const Pose2& pose() const { return pose_; }
  const Twist2& twist() const { return twist_; }
  /// Accumulated wheel angles as the encoders count them [rad]: left, right; positive driving forward.
  std::array<double, 2> encoderAngles() const;
  /// The same without the encoders' counts.
  std::array<double, 2> wheelAngles() const { return {wheels_[0].angle, wheels_[1].angle}; }
  ImuReading readImu();
  int slips() const { return slips_; }
  TrueBase trueBase() const { return {wheels_[0].true_radius, wheels_[1].true_radius, true_half_track_}; }

 private:
  struct Wheel {
    double true_radius;     // [m]
    double angle = 0.0;     // [rad] turned
    double slipping = 0.0;  // [s] left
  };

  RobotErrors errors_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_{0.0, 1.0};
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  std::array<Wheel, 2> wheels_;
  double true_half_track_;  // [m]
  double gyro_scale_, gyro_bias_;
  Pose2 pose_;
  Twist2 twist_;               // as the IMU feels it
  double acceleration_ = 0.0;  // [m/s^2]
  int slips_ = 0;
};

}  // namespace slam::sim
