// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>

#include "tools/convert/recording.hpp"

namespace slam {

struct CarmenOptions {
  std::optional<double> period;  ///< [s] between scans, where neither the stamps nor the logger's are times
};

/// CARMEN text logs: FLASER and ROBOTLASER1 (with their odometry as wheels) and ODOM lines. Reads the input twice: what
/// the whole says of mount, stamps and ranges without return holds for each line.
/// @throws std::runtime_error when the input cannot be opened, holds no scan, or the output cannot be written
Recording convertCarmen(const std::filesystem::path& in, const std::filesystem::path& out,
                        const CarmenOptions& options = {});

namespace carmen {

inline constexpr std::string_view kRobotLaser = "ROBOTLASER1";  ///< the line that tells its own bearings

/// First bearing and step [rad] of a FLASER line: 180 and 181, 360 and 361 beams mean 180 degrees in 1 or 0.5 degree
/// steps.
inline std::pair<double, double> beamLayout(std::size_t n) {
  return {-std::numbers::pi / 2.0, std::numbers::pi / static_cast<double>(n % 2 == 1 ? n - 1 : n)};
}

}  // namespace carmen
}  // namespace slam
