// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <sstream>

#include "app/device_configs.hpp"
#include "app/map/map_keeper.hpp"
#include "app/map/store_policy.hpp"
#include "app/observables.hpp"
#include "app/threads/mapper_thread.hpp"
#include "depth/depth_projection.hpp"
#include "tools/files.hpp"
#include "tools/sim/depth/depth_camera.hpp"

namespace slam::test {
namespace {

/// Values in words, with a blank between.
template <typename... Values>
std::string words(const Values&... values) {
  std::ostringstream text;
  text.precision(12);
  ((text << values << ' '), ...);
  return text.str();
}

}  // namespace

std::string boardSettings(const Config& config) {
  const HandsfreeConfig c = handsfreeConfig(config);
  return words(c.port, c.baud, c.mileage_rate, c.imu_rate, c.sample_age, static_cast<int>(c.chassis), c.wheel_radius,
               c.body_radius, c.may_drive, c.limits.max_speed, c.limits.max_turn_rate);
}

std::string baseSettings(const Config& config) {
  const SerialBaseConfig c = serialBaseConfig(config);
  return words(c.facts->driver, c.port, c.baud, c.robot.wheel_radius, c.robot.half_track, c.robot.counts_per_turn,
               c.robot.loop_rate, static_cast<int>(c.robot.address), static_cast<int>(c.robot.nodes[0]),
               static_cast<int>(c.robot.nodes[1]), c.robot.may_drive, c.gyro, c.limits.max_speed,
               c.limits.max_turn_rate);
}

std::string canSettings(const Config& config) {
  const CanBaseConfig c = canBaseConfig(config);
  return words(c.interface, c.wheels, c.imu, c.nodes[0], c.nodes[1], c.wheel.sign[0], c.wheel.sign[1],
               c.wheel.gear_ratio, static_cast<int>(c.protocol), c.pole_pairs, c.commands);
}

std::string imuSettings(const Config& config) {
  const SerialImuConfig c = serialImuConfig(config);
  return words(c.facts == nullptr ? "" : c.facts->driver, c.port, c.baud, imuRotation(config.imu_device));
}

std::string lidarSettings(const Config& config) {
  const SerialLidarConfig port = serialLidarConfig(config);
  const RplidarConfig c = rplidarConfig(config);
  return words(port.port, port.baud, c.baud, static_cast<int>(c.scan_mode), c.limits.min, c.limits.max);
}

std::string cameraSettings(const Config& config) {
  const OpenniConfig c = openniConfig(config);
  return words(c.uri, c.width, c.height, c.rate, c.record);
}

std::string threads(const Config& config) {
  std::string text = words(ticksPerPose(config));
  for (const WorkerConfig& c : {baseWorker(config), lidarWorker(config), depthWorker(config), estimatorWorker(config)})
    text += words(c.name, c.rate, c.priority);
  return text;
}

std::string projection(const Config& config) {
  sim::World world;
  world.addWall({3.2, -3.0}, {3.2, 3.0});
  world.add(sim::Box{1.6, 0.5, 0.0, 0.3, 0.3, 0.0, 0.06});  // a sill
  world.add(sim::Box{2.0, -0.4, 0.0, 0.4, 0.4, 0.6, 1.0});  // a shelf
  sim::DepthCamera camera(160, 120, 1);
  DepthProjection projection(config.depth_device.projection);
  DepthImage image;
  std::string text;
  for (std::uint64_t frame = 0; frame < 8; ++frame) {
    camera.capture(world, {}, frame, Timestamp{std::chrono::milliseconds(100 * frame)}, image);
    text += words(static_cast<int>(projection.project(image)));
    for (const PseudoBeam& beam : projection.laser().beams())
      text += words(static_cast<int>(beam.kind), beam.range, beam.free_from);
  }
  return text;
}

std::string keeping(const Config& original) {
  const Folder folder;
  Config config = original;
  if (!config.store.directory.empty()) config.store.directory = folder / "maps";
  std::filesystem::create_directories(folder / "maps");
  MapKeeper keeper(config);
  const Timestamp start{std::chrono::seconds(100)};
  const MapState map = keeper.begin(start);
  std::string text = words(keeper.writes(), keeper.name());
  if (!keeper.writes()) return text;
  using Due = StorePolicy::Due;
  StorePolicy policy(config.store);
  policy.endAttempt(Due::kCheckpoint, {.changes = 1}, start, keeper.checkpoint(start, map));
  policy.endAttempt(Due::kJournal, {.changes = 1}, start, keeper.journal(start, map));
  for (int s = 1; s < 200; ++s) {
    const Timestamp now = start + std::chrono::seconds(s);
    text += words(static_cast<int>(policy.due(now, 2, {1.0, 0.0, 0.0}, keeper.hasJournal())));
  }
  return text;
}

std::string savedMap(const Config& original) {
  const Folder folder;
  Config config = original;
  if (!config.output.map.empty()) config.output.map = folder / "map";
  const auto channels = std::make_unique<Channels>();
  const WallClock clock;
  MapperThread mapper(config, channels->mapper(), clock);
  mapper.finish();
  mapper.waitUntilSaved(monotonicNow() + std::chrono::seconds(10));
  return words(std::filesystem::exists(folder / "map.yaml"));
}

}  // namespace slam::test
