// SPDX-License-Identifier: BSD-3-Clause
#include <bot_core/planar_lidar_t.hpp>
#include <bot_core/pose_t.hpp>
#include <cstdint>
#include <cstdio>
#include <slam/ack_t.hpp>
#include <slam/command_t.hpp>
#include <slam/config_t.hpp>
#include <slam/counter_t.hpp>
#include <slam/depth_t.hpp>
#include <slam/device_health_t.hpp>
#include <slam/drive_t.hpp>
#include <slam/health_t.hpp>
#include <slam/imu_t.hpp>
#include <slam/map_edit_t.hpp>
#include <slam/map_meta_t.hpp>
#include <slam/map_tile_t.hpp>
#include <slam/odometry_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <slam/problem_t.hpp>
#include <slam/problems_t.hpp>
#include <slam/scan_t.hpp>
#include <slam/stage_health_t.hpp>
#include <slam/wheels_t.hpp>

template <typename Message>
void print(const char* package) {
  std::printf("%s.%s %016jx\n", package, Message::getTypeName(),
              static_cast<std::uintmax_t>(static_cast<std::uint64_t>(Message::getHash())));
}

template <typename... Messages>
void printAll(const char* package) {
  (print<Messages>(package), ...);
}

int main() {
  printAll<bot_core::planar_lidar_t, bot_core::pose_t>("bot_core");
  using namespace slam;
  printAll<ack_t, command_t, config_t, counter_t, depth_t, device_health_t, drive_t, health_t, imu_t, map_edit_t,
           map_meta_t, map_tile_t, odometry_t, pose_estimate_t, problem_t, problems_t, scan_t, stage_health_t,
           wheels_t>("slam");
}
