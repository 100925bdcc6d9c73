// SPDX-License-Identifier: BSD-3-Clause
#include "app/devices.hpp"

#include <utility>

#include "app/device_configs.hpp"
#include "depth/depth_projection.hpp"
#include "drivers/lidar/cola/cola_unit.hpp"
#include "drivers/lidar/search/lidar_search.hpp"
#include "drivers/stuck_sample_detector.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

constexpr int kRepeats = 5;  // images in a row

Problem problemOf(DepthStatus status) {
  switch (status) {
    case DepthStatus::kWrongSize:
      return problem::kImagesWrongSize;
    case DepthStatus::kNoDepth:
      return problem::kImagesEmpty;
    case DepthStatus::kTilted:
      return problem::kImagesTilted;
    case DepthStatus::kBelowFloor:
      return problem::kImagesBelowFloor;
    case DepthStatus::kOk:
      break;
  }
  return {};
}

}  // namespace

std::unique_ptr<LidarUnit> makeLidarUnit(const Config& config) {
  if (config.lidar_device.isSearched()) return nullptr;  // lidarFinder() finds it
  if (const LidarFacts* facts = lidarFacts(config))
    return std::make_unique<PacketLidar>(*facts, packetLidarConfig(config), &monotonicNow);
  if (config.lidar_device.driver == LidarDriver::kHokuyo)
    return std::make_unique<ScipUnit>(scipConfig(config), &monotonicNow);
  if (config.lidar_device.driver == LidarDriver::kSick)
    return std::make_unique<ColaUnit>(scipConfig(config).limits, &monotonicNow);
  return std::make_unique<RplidarUnit>(rplidarConfig(config), &monotonicNow);
}

LidarFinder lidarFinder(const Config& config) {
  if (!config.lidar_device.isSearched()) return {};
  return [config](const PortOpener& open, const std::atomic<bool>& cancel) -> FoundUnit {
    const LidarDeviceConfig& device = config.lidar_device;
    const LidarFinding found = LidarSearch(device.port, device.baud, open, &monotonicNow).find(cancel);
    FoundUnit unit{.baud = found.baud, .problem = found.problem, .is_open = found.is_open};
    Config as_found = config;
    as_found.lidar_device.baud = found.baud;
    switch (found.family) {
      case LidarFinding::kNone:
        return unit;
      case LidarFinding::kPackets:
        unit.unit = std::make_unique<PacketLidar>(*found.facts, packetLidarConfig(as_found), &monotonicNow);
        unit.line_device = found.facts->line_device;
        return unit;
      case LidarFinding::kRplidar:
        as_found.lidar_device.driver = LidarDriver::kRplidar;
        break;
      case LidarFinding::kHokuyo:
        as_found.lidar_device.driver = LidarDriver::kHokuyo;
        as_found.lidar_device.baud = device.baud;  // that of its USB does not matter
        break;
      case LidarFinding::kSick:
        as_found.lidar_device.driver = LidarDriver::kSick;
        break;
    }
    unit.unit = makeLidarUnit(as_found);
    unit.line_device = serialLidarConfig(as_found).line_device;
    return unit;
  };
}

std::unique_ptr<LidarThread> makeLidarThread(const Config& config, const SampleProducer<ReceivedScan>& scans) {
  const auto add = [scans, received = std::make_shared<ReceivedScan>()](const LaserScan& scan) {
    received->scan = scan;
    received->received = monotonicNow();
    scans.push(*received);
  };
  SerialLidarConfig port = serialLidarConfig(config);
  port.find = lidarFinder(config);
  return std::make_unique<LidarThread>(lidarWorker(config), port, makeLidarUnit(config), &monotonicNow, add);
}

std::unique_ptr<DepthThread> makeDepthThread(const Config& config, const DepthEnds& ends,
                                             std::function<std::string()> record_to) {
  const DepthDeviceConfig& device = config.depth_device;
  const auto add = [ends,
                    projection = device.isMounted() ? std::make_shared<DepthProjection>(device.projection) : nullptr,
                    repeats = std::make_shared<StuckSampleDetector>(kRepeats)](const DepthImage& image) -> Problem {
    if (!projection) return problem::kCameraNotMounted;
    // The noise of a depth sensor never repeats itself, still less what a robot sees that moves.
    const auto* pixels = reinterpret_cast<const std::uint8_t*>(image.depth.data());
    const bool repeated = repeats->isStuck(digestOf({pixels, image.depth.size() * sizeof(std::uint16_t)}));
    if (repeated && ends.moving) return problem::kCameraStuck;
    const Timestamp begin = monotonicNow();
    const DepthStatus status = projection->project(image);
    ends.work.add(monotonicNow() - begin);
    if (status == DepthStatus::kOk) ends.views.push(projection->laser());
    return problemOf(status);
  };
  OpenniConfig camera = openniConfig(config);
  camera.record_to = std::move(record_to);
  return std::make_unique<DepthThread>(depthWorker(config), camera, &monotonicNow, add);
}

}  // namespace slam
