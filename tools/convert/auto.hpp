// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>

#include "tools/convert/recording.hpp"

namespace slam {

/// LCM logs with slamd's channels: its sensors and the configuration that a field log brings. @throws
/// std::runtime_error when it cannot be opened, holds no scan, or the output cannot be written
Recording convertLcm(const std::filesystem::path& in, const std::filesystem::path& out);

/// Recognises the input by its content and converts it: CARMEN, ROS 1 and 2, Maebot and MBot, LCM, Wean Hall, Mines, or
/// a table of scans.
/// @throws std::runtime_error also when it is none of these
Recording convertAny(const std::filesystem::path& in, const std::filesystem::path& out);

}  // namespace slam
