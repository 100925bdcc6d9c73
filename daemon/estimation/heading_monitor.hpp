// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "core/samples.hpp"
#include "core/timestamp.hpp"
#include "estimation/gyro_monitor.hpp"

namespace slam {

struct HeadingMonitorConfig {
  double contradiction = 4.0;  ///< [1] standard deviations from which on the scans' drift is no noise any more
  double any_drift = 0.05;     ///< [rad/s] standard deviation of it before anything is known
  double match_sigma = 0.003;  ///< [rad] error of a matched heading, seldom less
  double gyro_noise = 5e-4;    ///< [rad per sqrt(s)] angle random walk of a gyro
  double bias_walk = 1e-4;     ///< [rad/s per sqrt(s)] how fast its bias may change while the robot moves
  double gyro_scale = 0.05;    ///< [1] error of its scale
  double time_offset = 0.02;   ///< [s] of its stamps against those of the scans, seldom more
  double match_error = 1.0;    ///< [m, rad] of a match by scans whose heading drifts: wheels and gyro lead
};

/// Compares the heading that matched scans tell with a gyro that has shown at rest what it reads there. Where a scan
/// contradicts itself, as that of two lidars of which one is turned, each match is as good as any, and the map that
/// grows from them turns with the robot. The filter follows, and the bias in it, too: only one that does not come from
/// the scans tells. A Kalman filter on
///
///     x = (e, r, s):   e += r dt + s dtheta_gyro      z = theta_scans - theta_gyro = e
///
/// finds the scans' drift r [rad/s] beside an error s of the gyro's scale. It is a contradiction where it is beyond its
/// own noise and what the bias may have changed since the robot stood still. The next rest decides which of the two is
/// wrong: a gyro whose bias has moved by as much was.
///
/// No allocation.
class HeadingMonitor {
 public:
  explicit HeadingMonitor(const HeadingMonitorConfig& config = {}) : config_(config) {}

  /// Compares with a scan that was fused. @param standstill the robot rests, by wheels and gyro
  /// @param theta [rad] heading in the map @param variance [rad^2] of it
  void compare(const GyroMonitor& gyro, Timestamp stamp, bool standstill, double theta, double variance);
  /// The interval has no end: the scans did not tell it, or the map moved.
  void interrupt() { last_.reset(); }

  /// The scans turn as no sound gyro does.
  bool contradicts() const { return contradicts_; }
  /// Of the scans [rad/s]: zero unless they contradict the gyro.
  double drift() const { return contradicts_ ? state_[kDrift] : 0.0; }
  /// Error of the gyro's scale [1] that the scans show, and its standard deviation.
  double scale() const { return state_[kScale]; }
  double scaleSigma() const { return bias_ ? std::sqrt(P_(kScale, kScale)) : config_.gyro_scale; }
  /// What a match's covariance lacks [m^2, m rad, rad^2]: zero unless its scans contradict the gyro.
  Eigen::Matrix3d matchError() const;

 private:
  enum Index { kDifference, kDrift, kScale };
  struct Last {
    Timestamp stamp;
    double theta;  // [rad]
    bool standstill;
    double rate;  // [rad/s] of the gyro, up to there
  };
  void learnBias(double rate, double variance);
  void begin();
  void predict(double seconds, double turn, double rate_change);
  void correct(double variance);

  HeadingMonitorConfig config_;
  std::optional<Last> last_;
  std::optional<GyroBias> bias_;  // at the last rest
  double moved_ = 0.0;            // [rad/s] by the bias, since the scans contradict it
  double difference_ = 0.0;       // [rad] z
  Eigen::Vector3d state_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d P_ = Eigen::Matrix3d::Zero();
  bool contradicts_ = false;
};

}  // namespace slam
