// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/pose2.hpp"
#include "core/pose_history.hpp"
#include "tools/common/output_file.hpp"

namespace slam {

/// Seconds with 6 decimals.
std::string secondsText(std::int64_t utime);

/// Writes a trajectory in TUM format: `t tx ty tz qx qy qz qw`, seconds with 6 decimals, one row a pose.
class TrajectoryWriter {
 public:
  /// @throws std::runtime_error when the file cannot be opened
  explicit TrajectoryWriter(const std::filesystem::path& file) : file_(file) {}
  void write(std::int64_t utime, const Pose2& pose);
  /// @throws std::runtime_error when anything written was lost (disk full)
  void close() { file_.close(); }

 private:
  OutputFile file_;
};

/// @param seconds of a file, since the epoch
/// @return std::nullopt beyond 4.6e9 s, of the year 2115, to either side: two stamps have a difference
std::optional<Timestamp> stampOf(long double seconds);

/// Poses sorted by stamp (rows of equal stamps keep their order).
using Trajectory = std::vector<StampedPose>;

/// @throws std::runtime_error with file and line for a row that is not eight numbers, or when there is no row
Trajectory readTrajectory(const std::filesystem::path& file);

/// @return the row within `tolerance` of the stamp, else interpolated between its neighbours; std::nullopt outside
std::optional<Pose2> poseAt(const Trajectory& trajectory, Timestamp stamp,
                            Duration tolerance = std::chrono::milliseconds(2));

}  // namespace slam
