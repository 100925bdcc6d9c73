// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>

#include "core/pose2.hpp"
#include "core/samples.hpp"
#include "estimation/ekf.hpp"
#include "estimation/wheel_scale.hpp"

namespace slam {

/// What matched scans show of the wheels, from the worst up.
enum class WheelReliability : std::uint8_t {
  kNone,        ///< there are none
  kRejected,    ///< they contradict the scans too much to be used
  kReliable,    ///< their noise model is not far off
  kConsistent,  ///< as good as their noise model, or nothing is known of them yet
};

struct WheelMonitorConfig {
  double memory = 50.0;         ///< [1] intervals of way that are remembered
  double interval = 0.05;       ///< [m, rad] an interval is as long as this at least, from one matched scan to another
  double contradiction = 3.0;   ///< [1] mean normalised squared error from which on the wheels are rejected ...
  double agreement = 1.5;       ///< [1] ... until it is as low as this
  double consistency = 1.1;     ///< [1] up to here they are consistent: the mean's own standard deviation is 0.1
  double largest_error = 10.0;  ///< [1] one interval counts for no more: a slip, a wrong match
  double least_noise = 0.1;     ///< [1] of the model's variance: the scans' own error is in it, too
  double scan_distance = 0.01;  ///< [m] standard deviation of a motion between two matched scans
  double scan_turn = 0.005;     ///< [rad] the same
  double slip = 0.03;           ///< [rad] wheels whose heading is this far off a match's have slipped
  WheelScaleConfig scale;

  void visitSettings(auto& v) {
    v.expert("wheel_contradiction", contradiction, "1", 1.0, 1000.0,
             "The wheels are ignored when their mean normalised squared error against the scans is above this.");
    v.expert("wheel_agreement", agreement, "1", 0.5, 1000.0,
             "Ignored wheels are used again when their mean normalised squared error against the scans is below this.");
  }
};

/// Assesses the wheels by the way from one matched scan to another, and corrects their scale. The filter's noise model
/// takes slip, a radius that is a little wrong and a lag of part of a scan; wheels that are wrong by almost two
/// standard deviations in the mean are worse than none: along a corridor, which a lidar cannot see, they would lead the
/// filter astray, and a turning lidar's scans are bent by the turns that they make up.
class WheelMonitor {
 public:
  explicit WheelMonitor(const EkfConfig& noise, const WheelMonitorConfig& config = {})
      : noise_(noise), config_(config), scale_(config.scale) {}

  /// @param unmatched no scan shows the motion: without wheels the filter would go on as fast as it last was
  /// @return the sample for the pose filter, its scale corrected; nothing while they are rejected and scans match
  std::optional<WheelSample> add(const WheelSample& sample, bool unmatched = false);

  /// Compares them with a matched scan. @param odometry filter without scans, at the scan's stamp
  /// @param complete the scan showed the whole pose
  void compare(const Ekf& odometry, const Pose2& T_map_base, bool complete);
  /// Where wheels and scans put the robot at one time, each in its own frame.
  /// @param turn_known the wheels measure the turn, and no gyro does
  void compare(const Pose2& T_odom_base, const Pose2& T_map_base, bool turn_known);
  /// The interval has no end: the scans did not show it, or the map moved.
  void interrupt() { begin_.reset(); }

  WheelReliability reliability() const;
  bool reliable() const { return reliable_; }
  /// Whether they slipped since the scan before. The walls show the heading whoever walks between them.
  /// @param turn [rad] from the heading that the wheels predicted to the match's
  bool slipped(double turn) const { return std::abs(turn) > config_.slip; }
  /// Times that they were rejected.
  int rejections() const { return rejections_; }
  /// Their way beside the scans'; a wrong radius is no reason to reject them.
  const WheelScale& scale() const { return scale_; }

  /// By how much their errors exceed the noise model's variances [1], at least 1.
  double distanceFactor() const { return std::max(1.0, distance_error_); }
  double turnFactor() const { return std::max(1.0, turn_error_); }
  /// Variance of their way [m^2] over `distance` [m] as measured from interval to interval, which may be less.
  double shownVariance(double distance) const {
    return std::max(config_.least_noise, distance_error_) * noise_.wheelTranslationVariance(distance);
  }
  /// Variance of their way as measured [m^2], over `distance` [m].
  double translationVariance(double distance) const {
    return distanceFactor() * noise_.wheelTranslationVariance(distance);
  }
  /// Variance of the heading as measured [rad^2]. @param by_gyro which tells it, and not they
  double headingVariance(double distance, double turn, bool by_gyro) const {
    return (by_gyro ? 1.0 : turnFactor()) * noise_.headingVariance(0.0, distance, turn, by_gyro);
  }

 private:
  struct Begin {
    Pose2 T_odom_base, T_map_base;
  };
  double worst() const { return std::max(distance_error_, turn_error_); }

  EkfConfig noise_;
  WheelMonitorConfig config_;
  std::optional<Begin> begin_;                      // of the interval
  double distance_error_ = 1.0, turn_error_ = 1.0;  // [1] normalised, squared, in the mean
  WheelScale scale_;
  RescaledWheels rescaled_;
  bool has_samples_ = false;  // a sample came
  bool reliable_ = true, held_back_ = false;
  int rejections_ = 0;
};

}  // namespace slam
