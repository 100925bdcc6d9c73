// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <filesystem>

#include "tools/sim/output.hpp"

namespace slam::sim {

/// Plays the robot in real time at byte level on pseudo-terminals DIR/lidar, DIR/board and DIR/imu (a stand-alone IMU),
/// and its depth camera on the socket DIR/depth (depth_wire.hpp). It stands until lidar and board are in use, then
/// drives the route and ends; SIGINT and SIGTERM end it early, with the truth files written.
/// @param can interface that takes wheels and IMU as CAN frames too, and then the board need not be in use; empty: none
/// @param nodes of the left and the right wheel there
/// @throws std::runtime_error, std::system_error when devices or files cannot be made
void playDevices(const SimOptions& options, const std::filesystem::path& directory, const std::string& can,
                 const std::array<int, 2>& nodes);

}  // namespace slam::sim
