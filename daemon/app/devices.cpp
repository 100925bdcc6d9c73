// SPDX-License-Identifier: BSD-3-Clause
#include "app/devices.hpp"

#include "drivers/repeat_watch.hpp"
#include "mapping/depth_projection.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

constexpr int kRepeats = 5;  // images in a row

int priority(const Config& config, int wanted) { return config.runtime.realtime ? wanted : 0; }

}  // namespace

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
  const auto add = [&exchange,
                    projection = device.isMounted() ? std::make_shared<DepthProjection>(device.projection) : nullptr,
                    repeats = std::make_shared<RepeatWatch>(kRepeats)](const DepthImage& image) -> const char* {
    if (!projection) return "images are not used: measure the camera's height above the floor and set depth.z";
    // The noise of a depth sensor never repeats itself, still less what a robot sees that moves.
    const auto* pixels = reinterpret_cast<const std::uint8_t*>(image.depth.data());
    const bool repeated = repeats->isStuck(digestOf({pixels, image.depth.size() * sizeof(std::uint16_t)}));
    if (repeated && exchange.moving) return "every image is the same: the camera is stuck, pull its plug";
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
