// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>

#include "core/estimates.hpp"

namespace slam {

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
};

}  // namespace slam
