// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "config/config.hpp"
#include "core/pose2.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// Accumulated angles of the two wheels [rad], positive driving forward.
struct AccumulatedAngles {
  Timestamp stamp;
  double left = 0.0, right = 0.0;
};

/// The gyro's turn rate about the base's upward axis [rad/s].
struct TurnRate {
  Timestamp stamp;
  double rate = 0.0;
};

/// A scan that the front end matched in all directions: the match itself, before wheels and gyro are blended in.
struct MatchedScan {
  Timestamp stamp;
  Pose2 T_map_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta) in map [m, m, rad]
};

/// What calibration needs of a log, each in stamp order.
struct SensorLog {
  std::vector<AccumulatedAngles> wheels;
  std::vector<MatchedScan> scans;
  std::vector<TurnRate> turn_rates;
  int scans_read = 0;
  bool angles_recorded = true;  ///< false: taken back from the dead reckoning by the configured geometry
  std::uint64_t rejected_messages = 0, skipped_bytes = 0;
  bool truncated = false;
};

/// Feeds a log to the pipeline and keeps its matches and the wheels' angles.
/// @throws std::runtime_error when the log cannot be read, lacks scans or wheels, or its wheels measure speed only
SensorLog readSensorLog(const Config& config, const std::filesystem::path& file,
                        const std::function<void(double log_seconds)>& progress = {});

}  // namespace slam
