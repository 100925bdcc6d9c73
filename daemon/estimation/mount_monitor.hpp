// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>

#include "core/pose2.hpp"
#include "core/pose_covariance.hpp"

namespace slam {

struct MountMonitorConfig {
  double interval = 0.5;       ///< [m] or [rad] between two comparisons: the matches' noise is little of it
  double match_sigma = 0.007;  ///< [m] of a way between two matched poses, by the matches
  double wheel_sigma = 0.02;   ///< [m per sqrt(m)] of it, by the wheels; what the intervals show counts beside ...
  double expected = 6.0;       ///< [1] ... these variances, which count as so many intervals ...
  double least_share = 0.05;   ///< [1] ... down to this share of them
  double turn_sigma = 0.01;    ///< [m/rad] by which the centre wanders that wheels turn about
  double same_turn = 0.02;     ///< [rad] odometry that turns otherwise than the scans has slipped, by more than this
                               ///< and as many radians for each of the turn
  double mostly = 0.8;         ///< [1] of the intervals must be without slip: else wheels are no measure
  double outlier = 2.5;        ///< [1] standard deviations at which an interval has lost half its weight
  double scale_sigma = 0.2;    ///< [1] of the wheels' scale
  int rounds = 4;              ///< of weights and variance
};

/// By how much a lidar's mount is off: what to add to its x, y [m] and yaw [rad].
struct MountError {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// Of the error itself, where it is not corrected.
  Eigen::Matrix3d secondMoment() const { return mean * mean.transpose() + covariance; }
};

/// Where the lidar sits by the ways that wheels and matched scans tell between two scans. A mount that is off by d and
/// delta makes the scans' way t_s of the wheels' t_w [Censi 2013]
///
///     t_s = a (t_w + delta (t_wy, -t_wx)) + (R - I) d                                                  (1)
///
/// where R is the turn between them and 1/a the wheels' scale. (1) is linear in (a, a delta, d), and is solved by least
/// squares over the last intervals, with the mount as measured as prior. Ways tell delta, turns tell d.
///
/// A mount that is found to be off by more than the prior has it was measured less well: the prior is widened by what
/// is found. Starting from none, one interval that lies beyond its own error widens it already.
///
/// What slips or lags looks like a mount, too, but not the same in left and right turns or in both halves of the way:
/// by how much the farther of each two is from the whole is added to the standard deviations. Where odometry turns
/// otherwise than the scans in more than a few intervals, its ways are no measure, and the prior stays.
///
/// No allocation.
class MountMonitor {
 public:
  /// @param prior covariance of (x, y, yaw) of the mount as it was measured [m, m, rad]
  explicit MountMonitor(const Eigen::Matrix3d& prior = Eigen::Matrix3d::Zero(), const MountMonitorConfig& config = {});

  /// At a matched scan. @param seen the match told all directions
  void compare(const Pose2& T_odom_base, const Pose2& T_map_base, bool seen);
  void interrupt() { begin_.reset(); }

  const MountError& error() const { return error_; }
  /// The map begins here: its first pose is right by definition, and others are as far as the robot went from it.
  void beginMap(const Pose2& T_map_base) { T_map_begin_ = T_map_base; }
  void transform(const Pose2& T_new_old) {
    T_map_begin_ = T_new_old * T_map_begin_;
    if (begin_) begin_->T_map_base = T_new_old * begin_->T_map_base;
  }
  /// What the error does to a pose since the map began: a mount that is off by E makes E^-1 T E of the way T.
  /// @return covariance of (x, y, theta) in map [m, m, rad]
  Eigen::Matrix3d covarianceAt(const Pose2& T_map_base) const {
    const Eigen::Matrix3d moved = Eigen::Matrix3d::Identity() - carrying(between(T_map_begin_, T_map_base));
    return rotated(moved * error_.secondMoment() * moved.transpose(), T_map_base.theta);
  }

 private:
  struct Poses {
    Pose2 T_odom_base, T_map_base;
  };
  struct Interval {
    Eigen::Vector2d wheels, scans;  // [m] ways
    double turn = 0.0;              // [rad]
    bool slipped = false;
    double weight = 1.0;
    double variance = 1.0;  // [m^2]
  };
  struct Solution {
    Eigen::Vector4d value;  // a, a delta, d
    Eigen::Matrix4d covariance;
  };
  using Rows = Eigen::Matrix<double, 2, 4>;

  static Rows rowsOf(const Interval& interval);
  template <typename Filter>
  Solution solve(double variance, Filter counts) const;
  void estimate();

  MountMonitorConfig config_;
  Eigen::Matrix3d prior_;
  std::optional<Poses> begin_;  // of the interval
  Pose2 T_map_begin_;
  std::array<Interval, 256> intervals_;  // a ring
  std::size_t count_ = 0;
  MountError error_;
};

}  // namespace slam
