// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "app/config.hpp"
#include "app/exchange.hpp"
#include "drivers/handsfree_board.hpp"
#include "drivers/openni_camera.hpp"
#include "drivers/rplidar_driver.hpp"
#include "estimation/wheel_odometry.hpp"
#include "mapping/depth_projection.hpp"
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

/// Waits longer from attempt to attempt.
class BackOff {
 public:
  void reset() { wait_ = Duration(0); }
  void wait(const std::atomic<bool>& cancel);

 private:
  Duration wait_{0};
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

  Exchange& exchange_;
  RplidarDriver driver_;
  std::unique_ptr<ReceivedScan> scan_;
  bool connected_ = false;
  BackOff back_off_;
  Worker worker_;
};

/// Thread *depth*: connects, reads, reconnects with back-off; pseudo-lasers into the queues.
class DepthThread {
 public:
  DepthThread(const Config& config, Exchange& exchange);
  ~DepthThread();
  Worker& worker() { return worker_; }
  OpenniCamera& camera() { return camera_; }

 private:
  void run();
  void addImage(const DepthImage& image);

  Exchange& exchange_;
  DepthProjection projection_;
  OpenniCamera camera_;
  bool connected_ = false;
  BackOff back_off_;
  Worker worker_;
};

}  // namespace slam
