// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Geometry>
#include <span>

#include "core/depth_image.hpp"
#include "tools/sim/world/world.hpp"

namespace slam::sim {

/// Renders a world as a pinhole camera sees it, without any error.
///
/// Depth is kept inverse: for a plane n . P = d and the ray P = Z r through a pixel, r = ((u - cx)/fx, (v - cy)/fy, 1),
///
///     1/Z = n . r / d,                                                                                      (1)
///
/// which is affine in (u, v). A polygon is thus filled row by row with one addition and one maximum per pixel;
/// cylinders and spheres are intersected with the rays within their rectangle on the screen.
class DepthRenderer {
 public:
  /// Nothing nearer than this is drawn.
  static constexpr double kNear = 0.02;  ///< [m]

  explicit DepthRenderer(const DepthIntrinsics& intrinsics) : intrinsics_(intrinsics) {}

  /// @param T_world_camera optical frame: x right, y down, z forward; the camera stands outside of all things
  /// @param inverse_depth  [1/m] along the optical axis, row by row from the upper left; 0 where nothing is seen
  void render(const World& world, const Eigen::Isometry3d& T_world_camera, std::span<float> inverse_depth) const;

  const DepthIntrinsics& intrinsics() const { return intrinsics_; }

 private:
  DepthIntrinsics intrinsics_;
};

}  // namespace slam::sim
