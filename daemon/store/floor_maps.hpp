// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "slam/map_state.hpp"

namespace slam {

/// The names of a list: separated by blanks or commas; "*" stands for all maps of the folder. Each once, in rising
/// order.
std::vector<std::string> floorNames(const std::filesystem::path& directory, const std::string& list);

/// Loads the maps that a lost robot is searched in beside the present one.
/// @param list as of floorNames()
/// @param lidar that they must have been made with, where it is now
/// @param remarks out: which of them cannot be used and why, one sentence each
Floors loadFloors(const std::filesystem::path& directory, const std::string& list, const std::string& present,
                  const LidarModel& lidar, std::vector<std::string>* remarks);

}  // namespace slam
