// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "app/config.hpp"
#include "app/device_thread.hpp"
#include "app/exchange.hpp"
#include "drivers/handsfree_board.hpp"
#include "drivers/openni_camera.hpp"
#include "drivers/rplidar_driver.hpp"
#include "estimation/wheel_odometry.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Thread *base*: the controller board's wheels and IMU into the queues.
class BaseThread {
 public:
  BaseThread(const Config& config, Exchange& exchange);
  Worker& worker() { return worker_; }
  HandsfreeBoard& board() { return board_; }

 private:
  void addWheels(const WheelAngles& angles);

  Exchange& exchange_;
  bool use_imu_;
  WheelOdometry odometry_;
  HandsfreeBoard board_;
  Worker worker_;
};

using LidarThread = DeviceThread<RplidarDriver>;
/// Thread *lidar*: scans into the queues.
std::unique_ptr<LidarThread> makeLidarThread(const Config& config, Exchange& exchange);

using DepthThread = DeviceThread<OpenniCamera>;
/// Thread *depth*: pseudo-lasers into the queues.
std::unique_ptr<DepthThread> makeDepthThread(const Config& config, Exchange& exchange);

}  // namespace slam
