// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/truth_recorder.hpp"

#include "tools/sim/lidar/lidar_model.hpp"

namespace slam::sim {
namespace {

constexpr HeightBand kLidarPlane{LidarModel::kHeight - 0.02, LidarModel::kHeight + 0.02};
constexpr int kWidth = 160, kHeight = 120;  // enough: the robot moves 6 cm from view to view
constexpr double kFloor = 0.005;            // [m] a point below this is one of the floor

}  // namespace

TruthRecorder::TruthRecorder(const World& world, std::uint64_t seed)
    : world_(world),
      lidar_(world, kLidarPlane, kLidarPlane),
      band_(world, kRobotBand, kLidarPlane),
      camera_(
          DepthIntrinsics::fromFieldOfView(kWidth, kHeight, DepthCamera::kHorizontalFov, DepthCamera::kVerticalFov)),
      mounting_(DepthMounting::drawn(seed)),
      inverse_depth_(camera_.intrinsics().pixels()) {}

void TruthRecorder::addBeam(const Pose2& T_world_base, double bearing, double range) {
  const Pose2 T_world_lidar = T_world_base * LidarModel::kExtrinsics;
  lidar_.seeRay(T_world_lidar.translation(), T_world_lidar.theta + bearing, range);
  band_.seeRay(T_world_lidar.translation(), T_world_lidar.theta + bearing, range);
}

void TruthRecorder::addPoint(const Eigen::Vector3d& eye, const Eigen::Vector3d& p) {
  const Eigen::Vector2d way = (p - eye).head<2>();
  if (way.squaredNorm() > kCameraRange * kCameraRange) return;
  if (p.z() < kFloor) band_.seeFloor(p.head<2>());
  if (p.z() >= kRobotBand.bottom && p.z() <= kRobotBand.top) band_.seeSurface(p.head<2>(), way);
}

void TruthRecorder::addView(const Pose2& T_world_base, Timestamp now) {
  if (now < next_view_) return;
  next_view_ = now + kCameraPeriod;
  const Eigen::Isometry3d T_world_camera = opticalPose(T_world_base, mounting_);
  camera_.render(world_, T_world_camera, inverse_depth_);
  const DepthIntrinsics& k = camera_.intrinsics();
  const float* inverse = inverse_depth_.data();
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u, ++inverse) {
      if (*inverse * kCameraRange < 1.0) continue;  // farther along the axis, thus along the floor
      const Eigen::Vector3d ray((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0);
      addPoint(T_world_camera.translation(), T_world_camera * (ray / static_cast<double>(*inverse)));
    }
  }
}

}  // namespace slam::sim
