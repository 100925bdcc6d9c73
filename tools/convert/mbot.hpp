// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "tools/convert/recording.hpp"

namespace slam {

/// A reference trajectory that a log carries beside its sensors.
struct MbotTruth {
  std::filesystem::path file;  ///< TUM file to write; empty: none
  std::string channel =
      "SLAM_POSE";  ///< of pose_xyt_t: SLAM_POSE of the course's own SLAM, TRUE_POSE of motion capture
};

/// Of the robot's wheels. What is not given is that of the robots of the log's year.
struct MbotBase {
  std::optional<double> metres_per_tick;  ///< [m]
  std::optional<double> width;            ///< [m] between the wheels
  std::optional<double> wheel_radius;     ///< [m] by which the log's angles are made of ticks
};

/// LCM event logs of Maebot and MBot: RPLidar, encoders (or, without them, ODOMETRY) and IMU.
/// @throws std::runtime_error when the input cannot be opened, holds no scan, or the output cannot be written
Recording convertMbot(const std::filesystem::path& in, const std::filesystem::path& out, const MbotTruth& truth = {},
                      const MbotBase& base = {});

/// The fingerprint of the scans of these robots.
inline constexpr std::uint64_t kMbotLidar = 0x89dc5b879a5056cf;

}  // namespace slam
