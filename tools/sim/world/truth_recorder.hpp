// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <vector>

#include "core/timestamp.hpp"
#include "tools/sim/depth/depth_camera.hpp"
#include "tools/sim/world/truth_map.hpp"

namespace slam::sim {

/// Collects what lidar and depth camera could have seen on a drive, had they no errors.
class TruthRecorder {
 public:
  static constexpr HeightBand kRobotBand{0.05, 0.80};  ///< from the floor clearance to the robot's height

  TruthRecorder(const World& world, std::uint64_t seed);

  /// A beam of the lidar. @param range [m] without error
  void addBeam(const Pose2& T_world_base, double bearing, double range);
  /// What the camera sees of the world as it is now; looks at most every kCameraPeriod.
  void addView(const Pose2& T_world_base, Timestamp now);

  MapImage lidarMap() const { return lidar_.image(); }  ///< at the lidar's height
  MapImage bandMap() const { return band_.image(); }    ///< in the robot's band

 private:
  static constexpr Duration kCameraPeriod = std::chrono::milliseconds(200);
  static constexpr double kCameraRange = 4.0;  ///< [m] along the floor, of useful depth

  void addPoint(const Eigen::Vector3d& eye, const Eigen::Vector3d& p);

  const World& world_;
  TruthMap lidar_, band_;
  DepthRenderer camera_;
  DepthMounting mounting_;
  std::vector<float> inverse_depth_;
  Timestamp next_view_ = Timestamp::min();
};

}  // namespace slam::sim
