// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <optional>

#include "core/pose2.hpp"
#include "core/timestamp.hpp"
#include "estimation/ekf.hpp"
#include "estimation/heading_monitor.hpp"
#include "estimation/wheel_monitor.hpp"

namespace slam {

struct ScanMonitorConfig {
  double memory = 10.0;        ///< [m] of way that is remembered, and one whole turn
  double contradiction = 3.0;  ///< [1] standard deviations between odometry and scans are no noise any more
};

/// Compares the way that matched scans tell with the odometry's, over so many metres that a small steady error shows. A
/// scan that what walks along drags with it, or that slides along what it sees too little of, agrees with the filter
/// scan by scan, because the filter follows it: only the sum tells.
///
///     D = e^(-d/memory) Ad D + (odometry's step)^-1 (scans' step)        S the same of the odometry's noise
///
/// Which of the two is wrong it does not say. Where D is beyond what the noise explains, the pose is uncertain by D.
///
/// No allocation.
class ScanMonitor {
 public:
  explicit ScanMonitor(const EkfConfig& noise, const ScanMonitorConfig& config = {}) : noise_(noise), config_(config) {}

  /// Compares with a scan that was fused. @param odometry filter without scans, at the scan's stamp
  /// @param covariance of the match, in map [m, m, rad]: a pose that is uncertain along a bare corridor follows the
  /// wheels there, so that its own would hide a contradiction
  /// @param gyro_scale what the scans have shown of it: in a turn a match that is off by degrees is no error of a scale
  /// that is known to a thousandth
  void compare(const Ekf& odometry, const Pose2& T_map_base, const Eigen::Matrix3d& covariance,
               const WheelMonitor& wheels, const HeadingMonitor& gyro_scale);
  /// The interval has no end, since the map moved.
  void interrupt() { last_.reset(); }
  /// Nothing that was told before counts: the robot is somewhere else.
  void reset() { *this = ScanMonitor(noise_, config_); }

  /// Scans and odometry tell different ways.
  bool contradicts() const { return contradicts_; }
  /// Of the pose, in base's axes [m, m, rad]: zero unless they contradict each other.
  const Eigen::Matrix3d& covariance() const { return excess_; }
  /// The part of it that belongs to a step of the way: a steady error adds up.
  /// @param moved by the step
  Eigen::Matrix3d covarianceOf(const Pose2& moved) const { return (1.0 - kept(moved)) * excess_; }

 private:
  struct Last {
    Timestamp stamp;
    Pose2 T_odom_base, T_map_base;
  };
  double kept(const Pose2& moved) const;

  EkfConfig noise_;
  ScanMonitorConfig config_;
  std::optional<Last> last_;
  Eigen::Vector3d difference_ = Eigen::Vector3d::Zero();  // D, in base's axes
  Eigen::Matrix3d noise_sum_ = Eigen::Matrix3d::Zero();   // S
  Eigen::Vector3d by_bias_ = Eigen::Vector3d::Zero();     // [m, m, rad per rad/s] what a gyro bias makes of the way
  Eigen::Vector3d by_turn_ = Eigen::Vector3d::Zero();     // [m, m, rad] the same of the turns' scale
  Eigen::Vector3d by_scale_ = Eigen::Vector3d::Zero();    // [m, m, rad] the same of the wheels' scale
  Eigen::Matrix3d excess_ = Eigen::Matrix3d::Zero();
  bool contradicts_ = false;
};

}  // namespace slam
