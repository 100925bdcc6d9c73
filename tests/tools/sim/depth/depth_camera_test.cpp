// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_camera.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace slam::sim::depth_camera_test {
namespace {

std::uint16_t median(std::vector<std::uint16_t> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

std::vector<std::uint16_t> patch(const DepthImage& image, int u0, int v0, int size) {
  std::vector<std::uint16_t> values;
  for (int v = v0; v < v0 + size; ++v) {
    for (int u = u0; u < u0 + size; ++u) {
      const std::uint16_t depth = image.depth[static_cast<std::size_t>(v * image.intrinsics.width + u)];
      if (depth != 0) values.push_back(depth);
    }
  }
  return values;
}

class DepthCameraMode : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(DepthCameraMode, SeesAWallAheadAndABoxToItsLeftOnTheLeft) {
  const auto [width, height] = GetParam();
  World world;
  world.addWall({4.05, -10.0}, {4.05, 10.0});
  world.add(Box{2.25, 0.5, 0.0, 0.5, 0.6, 0.0, 2.0});
  DepthCamera camera(width, height, 5);
  DepthImage image;
  camera.capture(world, {0.9, 0.0, 0.0}, 0, Timestamp{}, image);
  ASSERT_EQ(image.depth.size(), static_cast<std::size_t>(width * height));
  EXPECT_NEAR(median(patch(image, width / 2, height / 2, 20)), 3000, 30);
  const int left = width / 2 - static_cast<int>(0.4 * camera.intrinsics().fx);  // y = 0.4 m at 1 m
  EXPECT_NEAR(median(patch(image, left, height / 2, 20)), 1000, 30);
  // The floor: at the lowest row it is cy/fy below the axis, 0.40 m under the camera.
  EXPECT_NEAR(median(patch(image, width / 2, height - 4, 4)), 400.0 * camera.intrinsics().fy / (height / 2 - 2), 30);
}

INSTANTIATE_TEST_SUITE_P(Modes, DepthCameraMode, testing::Values(std::pair(640, 480), std::pair(320, 240)));

TEST(DepthMounting, IsOffByTheSeedAndAtMostItsTolerance) {
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const DepthMounting mounting = DepthMounting::drawn(seed);
    EXPECT_LE(std::abs(mounting.pitch), DepthMounting::kMaxTilt);
    EXPECT_LE(std::abs(mounting.roll), DepthMounting::kMaxTilt);
    EXPECT_EQ(mounting.pitch, DepthMounting::drawn(seed).pitch);
    sum += std::abs(mounting.pitch);
  }
  EXPECT_NEAR(sum / 50, DepthMounting::kMaxTilt / 2, DepthMounting::kMaxTilt / 5);
}

TEST(OpticalPose, LooksForwardAndPitchedDown) {
  const Eigen::Isometry3d level = opticalPose({1.0, 2.0, 0.0}, {});
  EXPECT_TRUE(level.translation().isApprox(Eigen::Vector3d(1.10, 2.0, 0.40)));
  EXPECT_TRUE(level.linear().col(2).isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(level.linear().col(0).isApprox(-Eigen::Vector3d::UnitY()));
  const Eigen::Vector3d down = opticalPose({}, {.pitch = 0.2}).linear().col(2);
  EXPECT_NEAR(down.z(), -std::sin(0.2), 1e-12);
  EXPECT_LT(opticalPose({}, {.roll = 0.2}).linear().col(0).z(), 0.0);  // the right side is lower
}

}  // namespace
}  // namespace slam::sim::depth_camera_test
