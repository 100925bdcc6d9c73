// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>

#include "core/pose2.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// Wheels that stop harder than tyres can brake: the robot ran into something and stands, or their counters died and it
/// drives on. Where scans show it decides. A plain value: it is copied with the filter state that it belongs to.
class AbruptStop {
 public:
  /// The wheels move. @param velocity [m/s] in base, mean over an interval
  void move(const Eigen::Vector2d& velocity);
  /// The wheels stand for an interval of `seconds`. Of coarse counters at a high rate single intervals are zero: two on
  /// either side of the stop count.
  /// @param braking [m/s^2] that tyres can at most  @return whether they have just stopped harder
  bool stand(double braking, double seconds, Timestamp stamp, const Pose2& T_map_base);
  /// Scans have moved the filter: the robot is where the wheels stopped, where it would be at the same speed, or
  /// elsewhere, as one that was pushed or carried. Only the second is taken for dead wheels.
  /// @param unknown [m] by which its place may be off
  void decide(Timestamp stamp, const Pose2& T_map_base, double unknown);
  /// The pose was set, or the map moved.
  void beginAt(Timestamp stamp, const Pose2& T_map_base) { stamp_ = stamp, T_map_stop_ = T_map_base; }
  void transform(const Pose2& T_new_old) { T_map_stop_ = T_new_old * T_map_stop_; }

  /// Nothing has shown yet that the wheels' zeros are true.
  bool doubtful() const { return speed_ > 0.0; }
  /// Scans show that the robot drives on.
  bool dead() const { return dead_; }
  double speed() const { return speed_; }  ///< [m/s] before the stop; 0: there was none, or it is confirmed

 private:
  Eigen::Vector2d previous_ = Eigen::Vector2d::Zero(), last_ = Eigen::Vector2d::Zero();  // [m/s] while they moved
  int quiet_ = 0;                                                                        // intervals since then
  double speed_ = 0.0;
  Timestamp stamp_{};  // of the stop
  Pose2 T_map_stop_;
  bool dead_ = false;
};

}  // namespace slam
