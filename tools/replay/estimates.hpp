// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <filesystem>

#include "core/estimates.hpp"
#include "frontend/front_end.hpp"
#include "tools/common/output_file.hpp"

namespace slam {

/// What the robot knew when it had used a scan.
struct ScanEstimate {
  std::int64_t utime = 0;  ///< [us] the scan's stamp as recorded
  LocalisationState state = LocalisationState::kInitialising;
  Pose2 T_map_base;                                      ///< at that stamp
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta) in map [m, m, rad]
  Pose2 T_odom_base;                                     ///< at that stamp, by wheels and IMU alone
  MatchResult match;
};

/// Of a scan just used, before a correction of the map moves the pose.
ScanEstimate estimateOf(const FrontEnd& front_end, const ScanOutcome& outcome, std::int64_t utime);

/// Writes estimates as comma-separated values: a row that names the columns, then one a scan. Numbers are plain
/// decimals with a point, whatever the locale; one that is not finite is `nan`. The status of a scan that the matcher
/// never saw (the first one, a copy, one too late, of a stuck lidar) is `none`.
class EstimateWriter {
 public:
  /// @throws std::runtime_error when the file cannot be opened
  explicit EstimateWriter(const std::filesystem::path& file);
  void write(const ScanEstimate& estimate);
  /// @throws std::runtime_error when anything written was lost
  void close() { file_.close(); }

 private:
  OutputFile file_;
};

}  // namespace slam
