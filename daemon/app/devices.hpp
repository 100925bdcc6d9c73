// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "app/config.hpp"
#include "app/exchange.hpp"
#include "drivers/handsfree_board.hpp"
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

/// Thread *lidar*: connects, reads, reconnects with back-off; scans into the queues.
class LidarThread {
 public:
  LidarThread(const Config& config, Exchange& exchange);
  ~LidarThread();
  Worker& worker() { return worker_; }
  RplidarDriver& driver() { return driver_; }

 private:
  void run();
  void addScan(const LaserScan& scan);
  void waitBackOff();

  Exchange& exchange_;
  RplidarDriver driver_;
  std::unique_ptr<ReceivedScan> scan_;
  bool connected_ = false;
  Duration back_off_{0};
  Worker worker_;
};

}  // namespace slam
