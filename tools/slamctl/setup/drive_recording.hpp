// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>

#include "config/config.hpp"
#include "tools/slamctl/setup/console.hpp"

namespace slam {

/// Runs slamd with a configuration for a while, and records what the sensors measure. It stores no map and no field
/// log, and drives nothing by itself: the robot is pushed, or driven as always.
/// @param seconds of the drive, which begins when scans and wheels come
/// @param console is shown how far it is @param folder for the configuration, slamd's words, and the log
/// @return the log @throws std::runtime_error where slamd does not run, or no scans or wheels come, with what it
/// printed
std::filesystem::path recordDrive(const Config& config, double seconds, const std::filesystem::path& folder,
                                  Console& console);

}  // namespace slam
