// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_camera.hpp"

#include <random>

namespace slam::sim {

DepthMounting DepthMounting::drawn(std::uint64_t seed) {
  std::mt19937_64 random(seed ^ 0xD1B54A32D192ED03ULL);
  std::uniform_real_distribution<double> tilt(-kMaxTilt, kMaxTilt);
  DepthMounting mounting;
  mounting.pitch = tilt(random);
  mounting.roll = tilt(random);
  return mounting;
}

Eigen::Isometry3d opticalPose(const Pose2& T_world_base, const DepthMounting& mounting) {
  Eigen::Matrix3d axes;  // the optical frame's axes in a frame with x forward, y left, z up
  axes << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const auto about = [](double angle, const Eigen::Vector3d& axis) { return Eigen::AngleAxisd(angle, axis); };
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  const Eigen::Vector2d p = T_world_base * Eigen::Vector2d(mounting.x, 0.0);
  T_world_camera.translation() << p.x(), p.y(), mounting.height;
  T_world_camera.linear() = about(T_world_base.theta, Eigen::Vector3d::UnitZ()) *
                            about(mounting.pitch, Eigen::Vector3d::UnitY()) *
                            about(mounting.roll, Eigen::Vector3d::UnitX()) * axes;
  return T_world_camera;
}

DepthCamera::DepthCamera(int width, int height, std::uint64_t seed, const DepthErrorModel& errors)
    : renderer_(DepthIntrinsics::fromFieldOfView(width, height, kHorizontalFov, kVerticalFov)),
      errors_(renderer_.intrinsics(), errors, seed),
      mounting_(DepthMounting::drawn(seed)),
      inverse_depth_(renderer_.intrinsics().pixels()) {}

void DepthCamera::capture(const World& world, const Pose2& T_world_base, std::uint64_t frame, Timestamp stamp,
                          DepthImage& image) {
  renderer_.render(world, opticalPose(T_world_base, mounting_), inverse_depth_);
  image.stamp = stamp;
  image.intrinsics = renderer_.intrinsics();
  image.depth.resize(image.intrinsics.pixels());
  errors_.apply(inverse_depth_, frame, image.depth);
}

}  // namespace slam::sim
