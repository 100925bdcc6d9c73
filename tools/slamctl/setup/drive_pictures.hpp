// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>

#include "config/config.hpp"
#include "mapping/colour_image.hpp"

namespace slam {

/// The returns of a drive's scans, placed by the wheels alone: by one geometry of wheels and lidar on the left, by
/// another one on the right, in one scale. Walls are thin where it is right. @return empty: the log has no wheels'
/// angles
/// @throws std::runtime_error where the log cannot be read
ColourImage scansOverWheels(const Config& left, const Config& right, const std::filesystem::path& log);

/// The map that slamd makes of a drive. @param folder for files @return PNG @throws std::runtime_error as replay()
std::string mapOfDrive(const Config& config, const std::filesystem::path& log, const std::filesystem::path& folder);

}  // namespace slam
