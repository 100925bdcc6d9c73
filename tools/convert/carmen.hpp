// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <numbers>
#include <string_view>
#include <utility>

/// What reader and writer of CARMEN logs share.
namespace slam::carmen {

inline constexpr std::string_view kRobotLaser = "ROBOTLASER1";  ///< the line that tells its own bearings

/// First bearing and step [rad] of a FLASER line: 180 and 181, 360 and 361 beams mean 180 degrees in 1 or 0.5 degree
/// steps.
inline std::pair<double, double> beamLayout(std::size_t n) {
  return {-std::numbers::pi / 2.0, std::numbers::pi / static_cast<double>(n % 2 == 1 ? n - 1 : n)};
}

}  // namespace slam::carmen
