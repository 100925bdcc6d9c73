// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>

#include "config/config.hpp"
#include "tools/common/trajectory.hpp"

namespace slam {

struct OverlayOptions {
  double first_seconds = 5.0;   ///< [s] of the log that count as the first visit
  double distance = 1.0;        ///< [m] from the first pose: nearer, and turned by no more than ...
  double rotation = 0.5236;     ///< [rad] ... this, is a visit
  double pair_distance = 0.30;  ///< [m] from a point to the wall of the first visit that is nearest to it
};

/// How well the scans of the last visit to the start lie on the walls that the first visit saw.
struct OverlayErrors {
  double mean = 0.0;                    ///< [m] distance of a paired point from its line, absolute
  double paired = 0.0;                  ///< [1] share of the last visit's points that have a pair
  int first_scans = 0, last_scans = 0;  ///< of each visit
  int points = 0;                       ///< of the last visit
};

/// Puts the scans of both visits into the map by the trajectory. The last visit is the last run of scans near the first
/// pose, in the second half of the log and after the robot had left.
/// @throws std::runtime_error when the log cannot be read, or when the robot does not leave or does not come back
OverlayErrors overlayVisits(const Trajectory& trajectory, const std::filesystem::path& log, const Config& config,
                            const OverlayOptions& options = {});

}  // namespace slam
