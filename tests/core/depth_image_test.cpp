// SPDX-License-Identifier: BSD-3-Clause
#include "core/depth_image.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace slam::depth_image_test {
namespace {

TEST(DepthIntrinsics, AFieldOfViewReachesToTheImagesBorders) {
  const double horizontal = 1.02, vertical = 0.79;  // [rad]
  const auto camera = DepthIntrinsics::fromFieldOfView(640, 400, horizontal, vertical);
  EXPECT_EQ(camera.pixels(), 640U * 400U);
  // Borders lie half a pixel outside the centres of the outermost pixels.
  EXPECT_NEAR(std::atan((camera.cx + 0.5) / camera.fx), 0.5 * horizontal, 1e-12);
  EXPECT_NEAR(std::atan((639.5 - camera.cx) / camera.fx), 0.5 * horizontal, 1e-12);
  EXPECT_NEAR(std::atan((camera.cy + 0.5) / camera.fy), 0.5 * vertical, 1e-12);
  EXPECT_NEAR(std::atan((399.5 - camera.cy) / camera.fy), 0.5 * vertical, 1e-12);
}

}  // namespace
}  // namespace slam::depth_image_test
