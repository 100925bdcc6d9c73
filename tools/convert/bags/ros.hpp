// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "tools/convert/recording.hpp"

namespace slam {

/// What a bag leaves open. An empty topic is chosen from what the bag holds.
struct RosOptions {
  std::string scan = {}, odometry = {}, imu = {};            ///< topics
  std::optional<double> wheel_radius = {}, half_track = {};  ///< [m] makes odometry of joint states
};

/// Bags of ROS 1 and 2 (.bag, .db3, .mcap; a folder of split ones) to our log. Reads the input twice: the first time
/// for the topics, clocks and frames.
/// @throws std::runtime_error when it cannot be opened, holds no scan that can be read, or the output cannot be written
Recording convertRos(const std::filesystem::path& in, const std::filesystem::path& out, const RosOptions& options = {});

}  // namespace slam
