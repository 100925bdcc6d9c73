// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_errors.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <set>

namespace slam::sim::depth_errors_test {
namespace {

const DepthIntrinsics kIntrinsics = DepthIntrinsics::fromFieldOfView(640, 480, 1.0226, 0.7966);

std::vector<std::uint16_t> measure(const std::vector<float>& inverse, std::uint64_t seed = 1, std::uint64_t frame = 0,
                                   const DepthErrorModel& model = {}) {
  std::vector<std::uint16_t> depth(kIntrinsics.pixels());
  DepthErrors(kIntrinsics, model, seed).apply(inverse, frame, depth);
  return depth;
}

std::vector<float> wallAt(double metres) {
  return std::vector<float>(kIntrinsics.pixels(), static_cast<float>(1.0 / metres));
}

TEST(ShiftToDepth, FollowsTheFormulaOfTheDevice) {
  EXPECT_NEAR(shiftToDepth(700, {}), 885, 1);
  EXPECT_NEAR(shiftToDepth(1000, {}), 3948, 1);
  EXPECT_EQ(shiftToDepth(100, {}), 0);   // nearer than 0.5 m
  EXPECT_EQ(shiftToDepth(1080, {}), 0);  // farther than 8 m
  EXPECT_EQ(shiftToDepth(2047, {}), 0);
}

class DepthErrorsOfAWall : public testing::TestWithParam<double> {};

TEST_P(DepthErrorsOfAWall, HaveTheDeviationAndTheStepsOfItsDistance) {
  const double metres = GetParam();
  const auto depth = measure(wallAt(metres));
  double sum = 0.0, squares = 0.0;
  int count = 0;
  std::set<std::uint16_t> values;
  for (const std::uint16_t millimetres : depth) {
    if (millimetres == 0) continue;
    const double error = millimetres * 1e-3 - metres;
    sum += error;
    squares += error * error;
    ++count;
    values.insert(millimetres);
  }
  EXPECT_NEAR(1.0 - count / static_cast<double>(depth.size()), 0.015, 0.003);
  const double sigma = 1.43e-3 * metres * metres, step = 2.93e-3 * metres * metres;  // [m]
  // Rounding to steps adds a twelfth of a step's square to the variance, and rounding to millimetres its own.
  EXPECT_NEAR(std::sqrt(squares / count), std::sqrt(sigma * sigma + (step * step + 1e-6) / 12), 0.1 * sigma + 5e-5);
  EXPECT_LT(std::abs(sum / count), 0.35 * step);
  ASSERT_GE(values.size(), 3U);
  for (auto next = std::next(values.begin()); next != values.end(); ++next) {
    EXPECT_NEAR((*next - *std::prev(next)) * 1e-3, step, 0.1 * step + 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Distances, DepthErrorsOfAWall, testing::Values(0.7, 1.0, 2.0, 3.5, 5.0));

TEST(DepthErrors, SeeNothingOutOfReach) {
  for (const double metres : {0.3, 0.49, 8.5, 20.0}) {
    for (const std::uint16_t depth : measure(wallAt(metres))) ASSERT_EQ(depth, 0) << metres;
  }
  for (const std::uint16_t depth : measure(std::vector<float>(kIntrinsics.pixels(), 0.0F))) ASSERT_EQ(depth, 0);
}

TEST(DepthErrors, CastAShadowToTheLeftOfWhatIsNear) {
  auto scene = wallAt(3.0);
  for (int v = 0; v < 480; ++v) {
    for (int u = 300; u < 400; ++u) scene[static_cast<std::size_t>(v * 640 + u)] = 1.0F;
  }
  const auto depth = measure(scene, 1, 0, {.dropout = 0.0, .edge_dropout = 0.0});
  // b fx (1/1 m - 1/3 m) = 28.5 pixels
  int shadow = 0, right = 0;
  for (int u = 260; u < 300; ++u) shadow += depth[static_cast<std::size_t>(200 * 640 + u)] == 0;
  for (int u = 300; u < 500; ++u) right += depth[static_cast<std::size_t>(200 * 640 + u)] == 0;
  EXPECT_NEAR(shadow, 28.5, 2.0);
  EXPECT_EQ(depth[200 * 640 + 299], 0);
  EXPECT_EQ(right, 0);
}

TEST(DepthErrors, AThinPoleCastsAThinShadowApartFromItself) {
  auto scene = wallAt(3.0);
  for (int u = 300; u < 308; ++u) scene[static_cast<std::size_t>(200 * 640 + u)] = 1.0F;
  const auto depth = measure(scene, 1, 0, {.dropout = 0.0, .edge_dropout = 0.0});
  int shadow = 0;
  for (int u = 250; u < 300; ++u) shadow += depth[static_cast<std::size_t>(200 * 640 + u)] == 0;
  EXPECT_NEAR(shadow, 8, 2);
  EXPECT_NE(depth[200 * 640 + 299], 0);
}

TEST(DepthErrors, LoseMorePixelsBesideAStep) {
  auto scene = wallAt(3.0);
  for (int v = 0; v < 480; ++v) {
    for (int u = 320; u < 640; ++u) scene[static_cast<std::size_t>(v * 640 + u)] = 1.0F / 3.4F;
  }
  const auto depth = measure(scene);
  int edge = 0, apart = 0;
  for (int v = 0; v < 480; ++v) {
    edge += depth[static_cast<std::size_t>(v * 640 + 319)] == 0;
    apart += depth[static_cast<std::size_t>(v * 640 + 317)] == 0;
  }
  EXPECT_NEAR(edge / 480.0, 0.5, 0.1);
  EXPECT_LT(apart / 480.0, 0.05);
}

TEST(DepthErrors, AreThoseOfTheirSeedAndFrame) {
  const auto wall = wallAt(2.0);
  EXPECT_EQ(measure(wall, 7, 3), measure(wall, 7, 3));
  EXPECT_NE(measure(wall, 7, 3), measure(wall, 7, 4));
  EXPECT_NE(measure(wall, 7, 3), measure(wall, 8, 3));
}

}  // namespace
}  // namespace slam::sim::depth_errors_test
