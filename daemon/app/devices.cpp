// SPDX-License-Identifier: BSD-3-Clause
#include "app/devices.hpp"

#include <algorithm>
#include <poll.h>

#include "runtime/clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kFirstBackOff = 100ms, kLongestBackOff = 1s;
constexpr Duration kPollTimeout = 100ms;  // the longest that a request to stop waits for the lidar thread

int priority(const Config& config, int wanted) { return config.runtime.realtime ? wanted : 0; }

}  // namespace

BaseThread::BaseThread(const Config& config, Exchange& exchange)
    : exchange_(exchange),
      use_imu_(config.imu_device.source == "device"),
      odometry_(config.base_device.geometry),
      board_({.port = config.base_device.port,
              .baud = config.base_device.baud,
              .mileage_rate = config.base_device.mileage_rate,
              .imu_rate = config.base_device.imu_rate,
              .sample_age = config.base_device.sample_age},
             &monotonicNow,
             {.wheels = [this](const WheelAngles& angles) { addWheels(angles); },
              .imu =
                  [this](const ImuSample& sample) {
                    if (!use_imu_) return;
                    exchange_.imu.tryPush(sample);
                    exchange_.imu_out.tryPush(sample);
                  }}),
      worker_({.name = "base",
               .rate = config.runtime.base_rate,
               .priority = priority(config, config.runtime.base_priority)},
              [this] { board_.tick(); }) {}

void BaseThread::addWheels(const WheelAngles& angles) {
  if (angles.restarted) odometry_.restart();
  const WheelReading reading{{angles.stamp, odometry_.add(angles.left, angles.right)}, {angles.left, angles.right}};
  exchange_.wheels.tryPush(reading);
  exchange_.wheels_out.tryPush(reading);
}

LidarThread::LidarThread(const Config& config, Exchange& exchange)
    : exchange_(exchange),
      driver_({.port = config.lidar_device.port,
               .baud = config.lidar_device.baud,
               .scan_mode = config.lidar_device.scan_mode,
               .range_min = static_cast<float>(config.localizer.lidar.range_min),
               .range_max = static_cast<float>(config.localizer.lidar.range_max)},
              &monotonicNow, [this](const LaserScan& scan) { addScan(scan); }),
      scan_(std::make_unique<ReceivedScan>()),
      worker_({.name = "lidar", .priority = priority(config, config.runtime.lidar_priority)}, [this] { run(); }) {}

LidarThread::~LidarThread() {
  worker_.stop();
  driver_.stop();
}

void LidarThread::run() {
  if (connected_) {
    connected_ = driver_.poll(kPollTimeout);
    return;
  }
  connected_ = driver_.connect(worker_.stopping());
  if (connected_) {
    back_off_ = 0ns;
  } else {
    waitBackOff();
  }
}

void LidarThread::waitBackOff() {
  back_off_ = std::clamp(2 * back_off_, kFirstBackOff, kLongestBackOff);
  for (const Timestamp end = monotonicNow() + back_off_; monotonicNow() < end && !worker_.stopping();) {
    ::poll(nullptr, 0, 20);
  }
}

void LidarThread::addScan(const LaserScan& scan) {
  scan_->scan = scan;
  scan_->received = monotonicNow();
  exchange_.scans.tryPush(*scan_);
  exchange_.scans_out.tryPush(*scan_);
}

}  // namespace slam
