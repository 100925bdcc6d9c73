// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>

namespace slam {

/// Files of one live run; empty paths are left out of the table.
struct LiveInput {
  std::filesystem::path record;            ///< what slamd published
  std::filesystem::path truth, waypoints;  ///< of slam-sim
  std::filesystem::path map, truth_map;    ///< yaml
  std::filesystem::path trajectory;        ///< to write
};

/// Prints accuracy of wheels, fused odometry and SLAM, map quality, latencies and load.
/// @throws std::runtime_error when the record holds no pose, or a file cannot be read
void printLiveReport(const LiveInput& input);

}  // namespace slam
