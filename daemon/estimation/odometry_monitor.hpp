// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "estimation/gyro_monitor.hpp"
#include "estimation/wheel_monitor.hpp"

namespace slam {

/// What the odometry's sensors are worth, by the matched scans.
struct OdometryMonitor {
  WheelMonitor wheels;
  GyroMonitor gyro;

  /// The interval has no end: the scans did not tell it, or the map moved.
  void interrupt() {
    wheels.interrupt();
    gyro.interrupt();
  }
};

}  // namespace slam
