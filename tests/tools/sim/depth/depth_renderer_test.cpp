// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_renderer.hpp"

#include <gtest/gtest.h>

#include "tools/sim/depth/depth_camera.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam::sim::depth_renderer_test {
namespace {

/// Depth along the optical axis, by casting the ray through a pixel. @return [m]
double castDepth(const World& world, const Eigen::Isometry3d& T_world_camera, const DepthIntrinsics& k, int u, int v) {
  const Eigen::Vector3d ray((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0);
  const Eigen::Vector3d direction = T_world_camera.linear() * ray.normalized(), eye = T_world_camera.translation();
  double distance = world.castRay(eye, direction, 100.0).value_or(100.0);
  if (direction.z() < 0.0) distance = std::min(distance, -eye.z() / direction.z());
  if (direction.z() > 0.0) distance = std::min(distance, (World::kCeiling - eye.z()) / direction.z());
  return distance / ray.norm();
}

struct View {
  const char* name;
  const char* scene;
  Pose2 pose;
  DepthMounting mounting = {};
  double time = 0.0;  // [s]
};

class DepthRendererView : public testing::TestWithParam<View> {};

TEST_P(DepthRendererView, IsWhatTheRaysSee) {
  const View& view = GetParam();
  Scene scene = makeScene(view.scene, 1);
  scene.world.setTime(view.time);
  const auto k = DepthIntrinsics::fromFieldOfView(640, 480, DepthCamera::kHorizontalFov, DepthCamera::kVerticalFov);
  const Eigen::Isometry3d T_world_camera = opticalPose(view.pose, view.mounting);
  std::vector<float> inverse(k.pixels());
  DepthRenderer(k).render(scene.world, T_world_camera, inverse);
  int compared = 0, different = 0;
  for (int v = 0; v < k.height; v += 3) {
    for (int u = v % 5; u < k.width; u += 5) {
      const double expected = castDepth(scene.world, T_world_camera, k, u, v);
      const double actual = 1.0 / inverse[static_cast<std::size_t>(v * k.width + u)];
      ++compared;
      different += std::abs(actual - expected) > 1e-4 * expected;
    }
  }
  EXPECT_EQ(compared, 160 * 128);
  EXPECT_LE(different, compared / 1000);  // a pixel on an edge may fall on either side
}

constexpr DepthMounting kTilted{.pitch = 0.25, .roll = -0.1};

INSTANTIATE_TEST_SUITE_P(Scenes, DepthRendererView,
                         testing::Values(View{"MeetingRoom", "meeting-room", {0.0, 0.0, 0.0}},
                                         View{"MeetingRoomTilted", "meeting-room", {0.2, -1.0, -0.7}, kTilted},
                                         View{"AmongTheTables", "meeting-room", {0.9, -2.3, -0.6}},
                                         View{"GazeboTruck", "gazebo", {0.0, -3.0, -0.4}},
                                         View{"GazeboSpheresTilted", "gazebo", {4.2, -2.9, 0.8}, kTilted},
                                         View{"GazeboBeneathATable", "gazebo", {1.2, -1.45, -0.3}},
                                         View{"Persons", "people", {0.3, 0.0, 0.0}, {}, 12.0},
                                         View{"PersonsTilted", "people", {1.6, 0.2, 0.1}, kTilted, 15.0},
                                         View{"OpenDoor", "open-door", {1.0, 0.1, 0.1}},
                                         View{"Corridor", "corridor-loop", {3.0, 0.2, 0.0}}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace slam::sim::depth_renderer_test
