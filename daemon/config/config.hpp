// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "config/choices.hpp"
#include "core/estimates.hpp"
#include "depth/depth_projection.hpp"
#include "estimation/wheel_odometry.hpp"
#include "firmware_if/can_odrive.hpp"
#include "frontend/front_end_config.hpp"
#include "mapping/occupancy_grid.hpp"
#include "slam/back_end_config.hpp"

namespace slam {

struct LidarDeviceConfig {
  LidarDriver driver = LidarDriver::kRplidar;
  std::string port = "/dev/rplidar";
  int baud = 115200;  ///< [bit/s]
  LidarScanMode scan_mode = LidarScanMode::kAuto;
};

struct BaseDeviceConfig {
  BaseDriver driver = BaseDriver::kHandsfree;
  BaseType type = BaseType::kDifferential;
  std::string port = "/dev/handsfree";
  int baud = 921600;  ///< [bit/s]
  DifferentialBase geometry;
  bool speed_commands = false;  ///< drive as SLAM_DRIVE says
  DriveOrder drive_order = DriveOrder::kFirst;
  SpeedLimits limits;          ///< whatever SLAM_DRIVE asks for
  double mileage_rate = 50.0;  ///< [Hz] polls of the wheel angles
  double imu_rate = 100.0;     ///< [Hz] polls of the IMU; readings that did not change are not used
  double sample_age = 0.010;   ///< [s] age of the board's values when it answers, until it has been found out
};

struct ImuDeviceConfig {
  ImuDriver driver = ImuDriver::kHandsfree;   ///< kHandsfree: the base board's IMU
  std::string port = "/dev/hfi";              ///< of "hfi"
  int baud = 921600;                          ///< [bit/s] of "hfi"
  double roll = 0.0, pitch = 0.0, yaw = 0.0;  ///< [rad] of the IMU's axes in base
};

/// The CAN bus of wheels (ODrive CANSimple) and IMU (Xsens frames).
struct CanConfig {
  std::string interface = "can0";
  int left_node = can::odrive::kLeftNode, right_node = can::odrive::kRightNode;
  bool left_reversed = false, right_reversed = false;  ///< the encoder counts down driving forward
  double gear_ratio = 1.0;                             ///< [1] turns of the encoder per turn of the wheel
  int watchdog_endpoint = 0;                           ///< of axis0.config.enable_watchdog in 0.6; 0: not known
};

struct DepthDeviceConfig {
  DepthDriver driver = DepthDriver::kOpenni2;
  std::string uri = "";           ///< OpenNI2's, or a recording (.oni); empty: the first camera
  int width = 640, height = 480;  ///< [pixel]
  int rate = 30;                  ///< [Hz]
  std::string record = "";        ///< .oni file; empty: none
  DepthProjectionConfig projection{.extrinsics = {.x = 0.10}, .floor = {}};

  /// Without its height above the floor no image can be used.
  bool isMounted() const { return projection.extrinsics.z > 0.0; }
};

struct LcmConfig {
  std::string url = "udpm://239.255.76.67:7667?ttl=0";
  double pose_rate = 100.0;  ///< [Hz] POSE, SLAM_POSE, SLAM_ODOMETRY
  double map_refresh = 5.0;  ///< [s] all tiles once
  bool commands = false;     ///< obey SLAM_COMMAND
};

struct RuntimeConfig {
  double estimator_rate = 200.0;  ///< [Hz]
  double base_rate = 211.0;       ///< [Hz] no multiple of the board's 50 Hz, so that requests meet all its phases
  bool realtime = true;           ///< SCHED_FIFO and mlockall where permitted
  std::string socket = "";        ///< path of the local socket for commands; empty: none
  int base_priority = 80;         ///< SCHED_FIFO
  int lidar_priority = 75;
  int depth_priority = 72;
  int estimator_priority = 70;
};

/// Maps that outlast the daemon.
struct StoreConfig {
  std::string directory = "";        ///< of all maps; empty: none are stored
  std::string map = "";              ///< to begin with; empty: the newest
  double journal_period = 1.0;       ///< [s]
  double checkpoint_period = 120.0;  ///< [s]
};

struct OutputConfig {
  std::string map = "";     ///< prefix of the map files written at the end and on save_map; empty: none
  std::string record = "";  ///< LCM event log of all that is published; empty: none
};

/// The field log.
struct LogConfig {
  std::string directory = "";  ///< of all runs; empty: none
  bool automatic = true;       ///< begin with slamd; else when a person wants it
  double quota = 2000.0;       ///< [MB] of all logs together
  double floor = 1000.0;       ///< [MB] that stay free on the disk
  double file_length = 600.0;  ///< [s]
  LogContent content = LogContent::kRaw;
  bool images = false;  ///< the camera's, too
};

/// Of slam-web, a program of its own.
struct WebConfig {
  static constexpr std::size_t kShortestToken = 12;

  std::string address = "127.0.0.1";
  int port = 8080;
  bool commands = false;
  std::string token = "";
};

/// All of slamd's settings. slam-replay uses the parts that are not about devices.
struct Config {
  RunMode mode = RunMode::kSlam;
  StoreConfig store;
  LidarDeviceConfig lidar_device;
  BaseDeviceConfig base_device;
  ImuDeviceConfig imu_device;
  CanConfig can;
  DepthDeviceConfig depth_device;
  FrontEndConfig front_end;
  BackEndConfig back_end;
  OccupancyGridConfig map;
  LcmConfig lcm;
  RuntimeConfig runtime;
  OutputConfig output;
  LogConfig log;
  WebConfig web;
  /// Keys that were set and are renamed, or do nothing any more, one line each: `file:line:column: key: what; fix`.
  std::vector<std::string> notices = {};
};

/// Settings of the back end: its own, and those that it shares with the front end.
inline BackEndConfig backEndConfig(const Config& config) {
  BackEndConfig back_end = config.back_end;
  back_end.reference = config.front_end.reference;
  back_end.match = config.front_end.match;
  back_end.match.range_sigma = config.front_end.lidar.range_sigma;
  back_end.T_base_depth = config.depth_device.projection.extrinsics.levelled();
  back_end.localise_only = config.mode == RunMode::kLocalise;
  return back_end;
}

inline BaseKinematics kinematicsOf(const BaseDeviceConfig& base) {
  return {base.type, base.geometry.wheel_radius, base.geometry.half_track};
}

inline FrontEndConfig frontEndConfig(const Config& config) {
  FrontEndConfig front_end = config.front_end;
  front_end.ekf.holonomic = kinematicsOf(config.base_device).type != BaseType::kDifferential;
  front_end.localise_only = config.mode == RunMode::kLocalise;
  return front_end;
}

}  // namespace slam
