// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "estimation/wheel_odometry.hpp"
#include "mapping/depth_projection.hpp"
#include "mapping/occupancy_grid.hpp"
#include "slam/back_end.hpp"
#include "slam/localizer.hpp"

namespace slam {

/// Who reads a sensor: a driver of ours, "lcm" (other people's programs) or "none".
struct LidarDeviceConfig {
  std::string driver = "rplidar";
  std::string port = "/dev/rplidar";
  int baud = 115200;               ///< [bit/s]
  std::string scan_mode = "auto";  ///< "auto", "express", "standard"
};

struct BaseDeviceConfig {
  std::string driver = "handsfree";
  std::string port = "/dev/handsfree";
  int baud = 921600;  ///< [bit/s]
  DifferentialBase geometry;
  double mileage_rate = 50.0;  ///< [Hz] polls of the wheel angles
  double imu_rate = 100.0;     ///< [Hz] polls of the IMU; readings that did not change are not used
  double sample_age = 0.010;   ///< [s] mean age of the board's values when it answers (it refreshes at 50 Hz)
};

struct ImuDeviceConfig {
  std::string driver = "handsfree";  ///< "handsfree": the base board's IMU
};

struct DepthDeviceConfig {
  std::string driver = "openni2";
  std::string uri = "";           ///< OpenNI2's, or a recording (.oni); empty: the first camera
  int width = 640, height = 480;  ///< [pixel]
  int rate = 30;                  ///< [Hz]
  std::string record = "";        ///< .oni file; empty: none
  DepthProjectionConfig projection{.extrinsics = {.x = 0.10, .z = 0.40}, .floor = {}};
};

struct LcmConfig {
  std::string url = "udpm://239.255.76.67:7667?ttl=0";
  double pose_rate = 100.0;  ///< [Hz] POSE, SLAM_POSE, SLAM_ODOMETRY
  double map_refresh = 5.0;  ///< [s] all tiles once
  bool commands = false;     ///< obey SLAM_COMMAND
};

struct RuntimeConfig {
  double estimator_rate = 200.0;  ///< [Hz]
  double base_rate = 200.0;       ///< [Hz]
  bool realtime = true;           ///< SCHED_FIFO and mlockall where permitted
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

/// All of slamd's settings. slam-replay uses the parts that are not about devices.
struct Config {
  std::string mode = "slam";  ///< "slam", "localise"
  StoreConfig store;
  LidarDeviceConfig lidar_device;
  BaseDeviceConfig base_device;
  ImuDeviceConfig imu_device;
  DepthDeviceConfig depth_device;
  LocalizerConfig localizer;
  BackEndConfig back_end;
  OccupancyGridConfig map;
  LcmConfig lcm;
  RuntimeConfig runtime;
  OutputConfig output;
};

/// Settings of the back end: its own, and those that it shares with the front end.
inline BackEndConfig backEndConfig(const Config& config) {
  BackEndConfig back_end = config.back_end;
  back_end.reference = config.localizer.reference;
  back_end.match = config.localizer.match;
  back_end.match.range_sigma = config.localizer.lidar.range_sigma;
  back_end.T_base_depth = config.depth_device.projection.extrinsics.levelled();
  back_end.localise_only = config.mode == "localise";
  return back_end;
}

inline LocalizerConfig localizerConfig(const Config& config) {
  LocalizerConfig localizer = config.localizer;
  localizer.localise_only = config.mode == "localise";
  return localizer;
}

}  // namespace slam
