// SPDX-License-Identifier: BSD-3-Clause
#include "app/devices.hpp"

#include <algorithm>
#include <poll.h>

#include "runtime/clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kFirstBackOff = 100ms, kLongestBackOff = 1s;
constexpr Duration kPollTimeout = 100ms;  // the longest that a request to stop waits for a device's thread

/// One round of a thread that owns a device: reads, or tries to connect.
template <typename Driver>
void keepConnected(Driver& driver, bool& connected, BackOff& back_off, const std::atomic<bool>& cancel) {
  if (connected) {
    connected = driver.poll(kPollTimeout);
    return;
  }
  connected = driver.connect(cancel);
  connected ? back_off.reset() : back_off.wait(cancel);
}

int priority(const Config& config, int wanted) { return config.runtime.realtime ? wanted : 0; }

}  // namespace

void BackOff::wait(const std::atomic<bool>& cancel) {
  wait_ = std::clamp(2 * wait_, kFirstBackOff, kLongestBackOff);
  for (const Timestamp end = monotonicNow() + wait_; monotonicNow() < end && !cancel;) ::poll(nullptr, 0, 20);
}

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
  const WheelReading reading{{angles.stamp, odometry_.add(angles.used())}, {angles.angles[0], angles.angles[1]}};
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

void LidarThread::run() { keepConnected(driver_, connected_, back_off_, worker_.stopping()); }

void LidarThread::addScan(const LaserScan& scan) {
  scan_->scan = scan;
  scan_->received = monotonicNow();
  exchange_.scans.tryPush(*scan_);
  exchange_.scans_out.tryPush(*scan_);
}

DepthThread::DepthThread(const Config& config, Exchange& exchange)
    : exchange_(exchange),
      projection_(config.depth_device.projection),
      camera_({.uri = config.depth_device.uri,
               .width = config.depth_device.width,
               .height = config.depth_device.height,
               .rate = config.depth_device.rate,
               .record = config.depth_device.record},
              &monotonicNow, [this](const DepthImage& image) { addImage(image); }),
      worker_({.name = "depth", .priority = priority(config, config.runtime.depth_priority)}, [this] { run(); }) {}

DepthThread::~DepthThread() {
  worker_.stop();
  camera_.stop();
}

void DepthThread::run() { keepConnected(camera_, connected_, back_off_, worker_.stopping()); }

void DepthThread::addImage(const DepthImage& image) {
  const Timestamp begin = monotonicNow();
  const DepthProjection::Status status = projection_.project(image);
  exchange_.depth_work.add(monotonicNow() - begin);
  camera_.status().set(DeviceState::kStreaming, describe(status));
  if (status != DepthProjection::Status::kOk) {
    camera_.status().rejects.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  exchange_.views.tryPush(projection_.laser());
  exchange_.views_out.tryPush(projection_.laser());
}

}  // namespace slam
