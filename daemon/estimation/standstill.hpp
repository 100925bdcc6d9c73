// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <optional>

#include "core/timestamp.hpp"

namespace slam {

struct StandstillConfig {
  double max_speed = 0.004;        ///< [m/s] of the wheels
  double max_turn_rate = 0.01;     ///< [rad/s] of the wheels
  double max_gyro_swing = 0.035;   ///< [rad/s] largest minus smallest gyro reading while standing
  double max_gyro_rate = 0.10;     ///< [rad/s] of gyro minus its bias: more is a robot carried or turned by hand
  double min_time = 0.4;           ///< [s] wheels and gyro must be quiet for this long, but ...
  double min_time_unbiased = 0.0;  ///< [s] ... only for this long while the gyro's bias is unknown

  /// Whether wheels stand. @param speed [m/s], turn_rate [rad/s] that they tell
  bool isQuiet(double speed, double turn_rate) const {
    return std::abs(speed) <= max_speed && std::abs(turn_rate) <= max_turn_rate;
  }

  void visitSettings(auto& v) {
    v.expert("standstill_speed", max_speed, "m/s", 0.0, 0.1,
             "The robot can stand still only while its wheels are slower than this.");
    v.expert("standstill_turn_rate", max_turn_rate, "rad/s", 0.0, 0.5,
             "The robot can stand still only while its wheels turn it slower than this.");
    v.expert("standstill_gyro_swing", max_gyro_swing, "rad/s", 0.0, 1.0,
             "The robot stands still only while the gyro's largest and smallest readings differ by no more than this.");
    v.expert("standstill_time", min_time, "s", 0.05, 10.0,
             "The robot stands still once wheels and gyro have been quiet for this time.");
  }
};

/// Says whether the robot stands still, from wheels and, where there is one, the gyro. A plain value: it is copied with
/// the filter state that it belongs to.
class Standstill {
 public:
  /// @param speed [m/s], turn_rate [rad/s]: mean over the interval that ends at `stamp`
  void addWheels(Timestamp stamp, double speed, double turn_rate, const StandstillConfig& config);
  /// @param rate [rad/s] reading of the gyro minus its bias, as far as that is known
  /// @param most [rad/s] from which on it says that the robot turns
  void addGyro(Timestamp stamp, double rate, double most, const StandstillConfig& config);

  /// @param min_time [s] quiet for so long is standstill
  bool active(Timestamp now, double min_time) const {
    return quiet_since_ && toSeconds(now - *quiet_since_) >= min_time;
  }

 private:
  std::optional<Timestamp> quiet_since_;
  double gyro_min_ = 0.0, gyro_max_ = 0.0;  // [rad/s] extremes since quiet_since_
  bool gyro_seen_ = false;
};

}  // namespace slam
