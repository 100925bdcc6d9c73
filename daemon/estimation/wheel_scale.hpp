// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "core/pose2.hpp"

namespace slam {

struct WheelScaleConfig {
  double initial_sigma = 0.2;   ///< [1] standard deviation of the scale before anything is known of it
  double noise = 3e-4;          ///< [1 per sqrt(m)] loads, tyres and floors change it
  double significance = 2.0;    ///< [1] standard deviations that it must differ from 1 by, to be believed
  double gate = 3.0;            ///< [1] standard deviations of the noise model; beyond, an interval was slip or a jump
  double largest_factor = 2.0;  ///< [1] up or down; what is further off is a fault and no scale
};

/// How much longer the wheels' way is than the one that matched scans tell: a radius or a gear that is not as
/// configured, a worn tyre, steady slip. Along a corridor, which a lidar cannot see, that error adds up with the way,
/// where noise grows with its root only. A Kalman filter of one state, the scale c, on
///
///     wheels = c * scans + noise      [m], along the direction of travel
///
/// which is regressed on the scans because theirs is the smaller error: the other way round noisy wheels would look
/// short.
class WheelScale {
 public:
  explicit WheelScale(const WheelScaleConfig& config = {})
      : config_(config), variance_(config.initial_sigma * config.initial_sigma) {}

  /// One interval of the way as wheels and as scans tell it, both from the pose at its beginning.
  /// @param variance [m^2] of its length by the noise model, wheels and scans together; beyond it lies slip
  /// @param excess   [1] the errors' mean square beside that
  void add(const Pose2& wheels, const Pose2& scans, double variance, double excess);

  /// What the wheels' way is to be divided by; 1 unless what is known of it says otherwise.
  double value() const;
  double sigma() const;

  /// The motion with its length corrected.
  Pose2 corrected(const Pose2& motion) const { return {motion.x / value(), motion.y / value(), motion.theta}; }

 private:
  WheelScaleConfig config_;
  double scale_ = 1.0, variance_;
};

/// Poses dead-reckoned by wheels, rewritten step by step with the scale known at each.
class RescaledWheels {
 public:
  Pose2 add(const Pose2& T_wheels_base, const WheelScale& scale) {
    rescaled_ = last_ ? rescaled_ * scale.corrected(between(*last_, T_wheels_base)) : T_wheels_base;
    last_ = T_wheels_base;
    return rescaled_;
  }

 private:
  std::optional<Pose2> last_;
  Pose2 rescaled_;
};

}  // namespace slam
