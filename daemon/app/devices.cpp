// SPDX-License-Identifier: BSD-3-Clause
#include "app/devices.hpp"

#include "mapping/depth_projection.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

int priority(const Config& config, int wanted) { return config.runtime.realtime ? wanted : 0; }

}  // namespace

BaseThread::BaseThread(const Config& config, Exchange& exchange)
    : exchange_(exchange),
      use_imu_(config.imu_device.driver == "handsfree"),
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

std::unique_ptr<LidarThread> makeLidarThread(const Config& config, Exchange& exchange) {
  const auto add = [&exchange, received = std::make_shared<ReceivedScan>()](const LaserScan& scan) {
    received->scan = scan;
    received->received = monotonicNow();
    exchange.scans.tryPush(*received);
    exchange.scans_out.tryPush(*received);
  };
  const LidarModel& model = config.localizer.lidar;
  return std::make_unique<LidarThread>(
      WorkerConfig{.name = "lidar", .priority = priority(config, config.runtime.lidar_priority)},
      RplidarConfig{.port = config.lidar_device.port,
                    .baud = config.lidar_device.baud,
                    .scan_mode = config.lidar_device.scan_mode,
                    .range_min = static_cast<float>(model.range_min),
                    .range_max = static_cast<float>(model.range_max)},
      &monotonicNow, add);
}

std::unique_ptr<DepthThread> makeDepthThread(const Config& config, Exchange& exchange) {
  const DepthDeviceConfig& device = config.depth_device;
  const auto add = [&exchange, projection = std::make_shared<DepthProjection>(device.projection)](
                       const DepthImage& image) -> const char* {
    const Timestamp begin = monotonicNow();
    const DepthStatus status = projection->project(image);
    exchange.depth_work.add(monotonicNow() - begin);
    if (status == DepthStatus::kOk) {
      exchange.views.tryPush(projection->laser());
      exchange.views_out.tryPush(projection->laser());
    }
    return describe(status);
  };
  return std::make_unique<DepthThread>(
      WorkerConfig{.name = "depth", .priority = priority(config, config.runtime.depth_priority)},
      OpenniConfig{.uri = device.uri,
                   .width = device.width,
                   .height = device.height,
                   .rate = device.rate,
                   .record = device.record},
      &monotonicNow, add);
}

}  // namespace slam
