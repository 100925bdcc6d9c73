// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "tools/sim/situation/situation.hpp"

namespace slam::sim {

/// What slam-sim was asked for.
struct SimOptions {
  std::string scene = "meeting-room";
  std::uint64_t seed = 1;
  double speed = 0.0;                          ///< [m/s] 0: the scene's
  double seconds = 0.0;                        ///< [s] 0: the whole route
  Situation situation = {};                    ///< of a log
  bool depth = false;                          ///< render the depth camera for a log: half of the work
  std::string base = "handsfree";              ///< word of base.driver: which one is played
  std::string imu = "hfi";                     ///< word of imu.driver: which one is played
  bool obey = false;                           ///< the robot drives as its base is commanded, not along the route
  bool vesc = false;                           ///< two VESCs drive the wheels on CAN, not two ODrives
  std::string lidar = "rplidar";               ///< word of lidar.driver: which one is played
  std::uint16_t lidar_tcp = 0;                 ///< TCP port at which it is played; 0: at a serial port
  std::filesystem::path faults = {};           ///< script of what goes wrong with the devices; empty: nothing
  std::filesystem::path truth = {};            ///< TUM file of true poses; empty: none
  std::filesystem::path waypoints = {};        ///< true poses at the measured waypoints; empty: none
  std::filesystem::path truth_map = {};        ///< prefix of the true map of the robot's height band; empty: none
  std::filesystem::path truth_map_lidar = {};  ///< prefix of the true map at the lidar's height; empty: none
};

}  // namespace slam::sim
