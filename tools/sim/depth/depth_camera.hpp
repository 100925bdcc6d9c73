// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/depth_image.hpp"
#include "core/pose2.hpp"
#include "tools/sim/depth/depth_errors.hpp"
#include "tools/sim/depth/depth_renderer.hpp"
#include "tools/sim/world/world.hpp"

namespace slam::sim {

/// How the camera is fixed to the robot: as drawn, and as no bracket is perfect.
struct DepthMounting {
  double x = 0.10, height = 0.40;  ///< [m] ahead of the base's centre; above the floor
  double pitch = 0.0;              ///< [rad] positive: looks down
  double roll = 0.0;               ///< [rad] positive: its right side is lower

  /// Pitch and roll off by up to kMaxTilt.
  static DepthMounting drawn(std::uint64_t seed);
  static constexpr double kMaxTilt = 0.3 * std::numbers::pi / 180.0;  ///< [rad]
};

/// An Asus Xtion Pro Live on the robot, looking forward.
class DepthCamera {
 public:
  static constexpr double kHorizontalFov = 1.0226, kVerticalFov = 0.7966;  ///< [rad]
  static constexpr double kHeight = DepthMounting{}.height;                ///< [m] above the floor
  static constexpr Pose2 kExtrinsics{DepthMounting{}.x, 0.0, 0.0};         ///< T_base_depth

  DepthCamera(int width, int height, std::uint64_t seed, const DepthErrorModel& errors = {});

  /// The image at a true pose, with the camera's errors. @param frame index: the same one has the same noise
  void capture(const World& world, const Pose2& T_world_base, std::uint64_t frame, Timestamp stamp, DepthImage& image);

  const DepthIntrinsics& intrinsics() const { return renderer_.intrinsics(); }
  const DepthMounting& mounting() const { return mounting_; }

 private:
  DepthRenderer renderer_;
  DepthErrors errors_;
  DepthMounting mounting_;
  std::vector<float> inverse_depth_;  // [1/m]
};

/// Pose of the optical frame (x right, y down, z forward) in world.
Eigen::Isometry3d opticalPose(const Pose2& T_world_base, const DepthMounting& mounting);

}  // namespace slam::sim
