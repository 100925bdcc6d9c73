// SPDX-License-Identifier: BSD-3-Clause
#include "app/device_configs.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace slam {
namespace {

robolink::ChassisType chassisOf(BaseType type) {
  switch (type) {
    case BaseType::kOmni3:
      return robolink::ChassisType::kOmni3;
    case BaseType::kMecanum4:
      return robolink::ChassisType::kMecanum4;
    case BaseType::kDifferential:
      break;
  }
  return robolink::ChassisType::kDifferential2;
}

rplidar::ModeWish wishOf(LidarScanMode mode) {
  switch (mode) {
    case LidarScanMode::kExpress:
      return rplidar::ModeWish::kExpress;
    case LidarScanMode::kStandard:
      return rplidar::ModeWish::kStandard;
    case LidarScanMode::kAuto:
      break;
  }
  return rplidar::ModeWish::kDensest;
}

RangeLimits rangesOf(const LidarModel& model) {
  return {static_cast<float>(model.range_min), static_cast<float>(model.range_max)};
}

int lidarBaud(const Config& config) {
  constexpr int kRplidar = 115200;  // A1, A2M8
  if (config.lidar_device.baud > 0) return config.lidar_device.baud;
  const LidarFacts* facts = lidarFacts(config);
  return facts != nullptr ? facts->baud : kRplidar;
}

int priority(const Config& config, int wanted) { return config.runtime.realtime ? wanted : 0; }

}  // namespace

const BaseFacts* baseFacts(const Config& config) { return findBase(wordOf(config.base_device.driver)); }

SerialBaseConfig serialBaseConfig(const Config& config) {
  const BaseDeviceConfig& base = config.base_device;
  const BaseFacts& facts = *baseFacts(config);
  return {.facts = &facts,
          .port = base.port,
          .baud = base.baud > 0 ? base.baud : facts.baud,
          .robot = {.wheel_radius = base.geometry.wheel_radius,
                    .half_track = base.geometry.half_track,
                    .counts_per_turn = base.counts_per_turn > 0.0 ? base.counts_per_turn : facts.counts_per_turn,
                    .loop_rate = base.loop_rate,
                    .address = static_cast<std::uint8_t>(base.address),
                    .nodes = {static_cast<std::uint8_t>(config.can.left_node),
                              static_cast<std::uint8_t>(config.can.right_node)},
                    .may_drive = base.speed_commands},
          .gyro = config.imu_device.driver == ImuDriver::kBase,
          .limits = base.limits,
          .in_background = true};
}

HandsfreeConfig handsfreeConfig(const Config& config) {
  const BaseDeviceConfig& base = config.base_device;
  const BaseKinematics kinematics = kinematicsOf(base);
  return {.port = base.port,
          .baud = base.baud > 0 ? base.baud : robolink::kBaud,
          .mileage_rate = base.mileage_rate,
          .imu_rate = base.imu_rate,
          .sample_age = base.sample_age,
          .chassis = chassisOf(kinematics.type),
          .wheel_radius = kinematics.wheel_radius,
          .body_radius = kinematics.body_radius,
          .may_drive = base.speed_commands,
          .limits = base.limits,
          .in_background = true};
}

CanBaseConfig canBaseConfig(const Config& config) {
  const CanConfig& can = config.can;
  return {.interface = can.interface,
          .wheels = config.base_device.driver == BaseDriver::kCan,
          .imu = config.imu_device.driver == ImuDriver::kCan,
          .protocol = can.protocol,
          .nodes = {can.left_node, can.right_node},
          .pole_pairs = can.pole_pairs,
          .wheel = {.sign = {can.left_reversed ? -1.0 : 1.0, can.right_reversed ? -1.0 : 1.0},
                    .gear_ratio = can.gear_ratio},
          .commands = config.base_device.speed_commands,
          .wheel_radius = config.base_device.geometry.wheel_radius,
          .half_track = config.base_device.geometry.half_track,
          .limits = config.base_device.limits};
}

const ImuFacts* imuFacts(const Config& config) { return findImu(wordOf(config.imu_device.driver)); }

SerialImuConfig serialImuConfig(const Config& config) {
  return {
      .facts = imuFacts(config), .port = config.imu_device.port, .baud = config.imu_device.baud, .in_background = true};
}

IioImuConfig iioImuConfig(const Config& config) { return {.device = config.imu_device.port}; }

const LidarFacts* lidarFacts(const Config& config) {
  const LidarDeviceConfig& lidar = config.lidar_device;
  return findLidar(lidar.driver == LidarDriver::kLds ? wordOf(lidar.model) : wordOf(lidar.driver));
}

SerialLidarConfig serialLidarConfig(const Config& config) {
  const LidarFacts* facts = lidarFacts(config);
  const LidarDriver driver = config.lidar_device.driver;
  const LineDevice other = driver == LidarDriver::kRplidar  ? LineDevice::kRplidar
                           : driver == LidarDriver::kHokuyo ? LineDevice::kHokuyo
                                                            : LineDevice::kUnknown;
  return {.port = config.lidar_device.port,
          .baud = lidarBaud(config),
          .line_device = facts != nullptr ? facts->line_device : other};
}

PacketLidarConfig packetLidarConfig(const Config& config) {
  return {.baud = lidarBaud(config), .limits = rangesOf(config.front_end.lidar)};
}

ScipConfig scipConfig(const Config& config) {
  return {.baud = config.lidar_device.baud, .limits = rangesOf(config.front_end.lidar)};
}

RplidarConfig rplidarConfig(const Config& config) {
  return {.baud = lidarBaud(config),
          .scan_mode = wishOf(config.lidar_device.scan_mode),
          .limits = rangesOf(config.front_end.lidar)};
}

OpenniConfig openniConfig(const Config& config) {
  const DepthDeviceConfig& device = config.depth_device;
  return {
      .uri = device.uri, .width = device.width, .height = device.height, .rate = device.rate, .record = device.record};
}

Eigen::Matrix3d imuRotation(const ImuDeviceConfig& imu) {
  return (Eigen::AngleAxisd(imu.yaw, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(imu.pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(imu.roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

ImuSample inBase(const Eigen::Matrix3d& R_base_imu, const ImuSample& sample) {
  return {sample.stamp, R_base_imu * sample.gyro, R_base_imu * sample.accel};
}

WorkerConfig baseWorker(const Config& config) {
  return {.name = "base", .rate = config.runtime.base_rate, .priority = priority(config, config.runtime.base_priority)};
}

WorkerConfig lidarWorker(const Config& config) {
  return {.name = "lidar", .priority = priority(config, config.runtime.lidar_priority)};
}

WorkerConfig depthWorker(const Config& config) {
  return {.name = "depth", .priority = priority(config, config.runtime.depth_priority)};
}

WorkerConfig estimatorWorker(const Config& config) {
  return {.name = "estimator",
          .rate = config.runtime.estimator_rate,
          .priority = priority(config, config.runtime.estimator_priority)};
}

WorkerConfig poseWorker(const Config& config) {
  constexpr int kHighest = 99;
  // Above the estimator's, which goes on working when the pose is told.
  return {.name = "pose", .priority = priority(config, std::min(kHighest, config.runtime.estimator_priority + 1))};
}

std::uint64_t ticksPerPose(const Config& config) {
  return static_cast<std::uint64_t>(std::max(1.0, std::round(config.runtime.estimator_rate / config.lcm.pose_rate)));
}

}  // namespace slam
