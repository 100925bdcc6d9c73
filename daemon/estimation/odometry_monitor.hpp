// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "estimation/gyro_monitor.hpp"
#include "estimation/heading_monitor.hpp"
#include "estimation/lidar_delay.hpp"
#include "estimation/mount_monitor.hpp"
#include "estimation/scan_monitor.hpp"
#include "estimation/wheel_monitor.hpp"

namespace slam {

/// What the odometry's sensors are worth by the matched scans, and these by the odometry.
struct OdometryMonitor {
  WheelMonitor wheels;
  GyroMonitor gyro;
  ScanMonitor scans;
  HeadingMonitor heading;
  MountMonitor mount = MountMonitor();
  LidarDelay delay = LidarDelay();

  /// The interval has no end: the scans did not tell it, or the map moved, with which the mount's interval moves.
  void interrupt() {
    wheels.interrupt();
    gyro.interrupt();
    scans.interrupt();
    heading.interrupt();
    delay.interrupt();
  }
  /// The robot is somewhere else: what scans told before is nothing to compare with.
  void reset() {
    interrupt();
    mount.interrupt();
    scans.reset();
  }
};

}  // namespace slam
