// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/standstill.hpp"

#include <algorithm>
#include <cmath>

namespace slam {

void Standstill::addWheels(Timestamp stamp, double speed, double turn_rate, const StandstillConfig& config) {
  if (!config.isQuiet(speed, turn_rate)) {
    quiet_since_.reset();
  } else if (!quiet_since_) {
    quiet_since_ = stamp;
    gyro_seen_ = false;
  }
}

void Standstill::addGyro(Timestamp stamp, double rate, double most, const StandstillConfig& config) {
  if (!quiet_since_) return;
  gyro_min_ = gyro_seen_ ? std::min(gyro_min_, rate) : rate;
  gyro_max_ = gyro_seen_ ? std::max(gyro_max_, rate) : rate;
  gyro_seen_ = true;
  if (gyro_max_ - gyro_min_ <= config.max_gyro_swing && std::abs(rate) <= most) return;
  quiet_since_ = stamp;  // the wheels stand but the robot turns: begin to wait anew
  gyro_min_ = gyro_max_ = rate;
}

}  // namespace slam
