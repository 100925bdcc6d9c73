// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <optional>

#include "core/pose2.hpp"
#include "estimation/ekf.hpp"
#include "slam/wheel_scale.hpp"

namespace slam {

struct WheelTrustConfig {
  double memory = 50.0;         ///< [1] stretches of way that are remembered
  double stretch = 0.05;        ///< [m, rad] a stretch is as long as this at least, from one matched scan to another
  double contradiction = 3.0;   ///< [1] mean normalised squared error from which on the wheels are not heard ...
  double agreement = 1.5;       ///< [1] ... until it is as low as this
  double guidance = 2.0;        ///< [1] from here on what they tell is no better a guess than going on as before
  double scan_distance = 0.01;  ///< [m] standard deviation of a motion between two matched scans
  double scan_turn = 0.005;     ///< [rad] the same
};

/// Whether the wheels can be believed, judged by what they tell of the way from one matched scan to another. The
/// filter's noise model takes slip, a radius that is a little wrong and a lag of part of a scan; wheels that are wrong
/// by almost two standard deviations in the mean are worse than none: along a corridor, which a lidar cannot see,
/// they would lead the filter astray, and a turning lidar's scans are bent by the turns that they make up.
class WheelTrust {
 public:
  explicit WheelTrust(const EkfConfig& noise, const WheelTrustConfig& config = {}) : noise_(noise), config_(config) {}

  /// Where wheels and scans put the robot at one time, each in its own frame.
  /// @param turn_known the wheels tell the turn, and no gyro does
  void add(const Pose2& T_odom_base, const Pose2& T_map_base, bool turn_known);
  /// The stretch has no end: the scans did not tell it, or the map moved.
  void interrupt() { begin_.reset(); }

  /// Their way beside the scans'; a wrong radius is no reason not to believe them.
  const WheelScale& scale() const { return scale_; }
  bool believed() const { return believed_; }
  /// They tell the next pose better than the motion before does.
  bool guides() const { return believed_ && worst() < config_.guidance; }
  /// They are as good as the noise model says, or nothing is known of them yet.
  bool keepPromise() const { return believed_ && worst() <= 1.0; }
  /// By how much their errors exceed the noise model's variances [1], at least 1.
  double distanceFactor() const { return std::max(1.0, distance_error_); }
  double turnFactor() const { return std::max(1.0, turn_error_); }
  /// Times that they were not believed any more.
  int withdrawn() const { return withdrawn_; }

 private:
  struct Begin {
    Pose2 T_odom_base, T_map_base;
  };
  double worst() const { return std::max(distance_error_, turn_error_); }

  EkfConfig noise_;
  WheelTrustConfig config_;
  std::optional<Begin> begin_;                      // of the stretch
  double distance_error_ = 1.0, turn_error_ = 1.0;  // [1] normalised, squared, in the mean
  WheelScale scale_;
  bool believed_ = true;
  int withdrawn_ = 0;
};

}  // namespace slam
