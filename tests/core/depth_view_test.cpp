// SPDX-License-Identifier: BSD-3-Clause
#include "core/depth_view.hpp"

#include <chrono>
#include <gtest/gtest.h>
#include <memory>

namespace slam::depth_view_test {
namespace {

std::unique_ptr<PseudoLaser> laser() {
  auto laser = std::make_unique<PseudoLaser>();
  laser->stamp = Timestamp(std::chrono::seconds(7));
  laser->bearing_min = -0.5F;
  laser->bearing_step = 0.01F;
  laser->size = 4;
  laser->storage[0] = {PseudoBeam::Kind::kHit, 2.0F, 0.6F};
  laser->storage[1] = {PseudoBeam::Kind::kUnknown, 9.0F, 0.0F};
  laser->storage[2] = {PseudoBeam::Kind::kFree, 3.0F, 0.7F};
  laser->storage[3] = {PseudoBeam::Kind::kHit, 1.0F, 1.0F};
  laser->push({.beam = 2, .from = 3.1F, .to = 3.4F});
  laser->push({.beam = 3, .from = 1.5F, .to = 1.6F});
  return laser;
}

TEST(DepthView, KeepsTheInformativeBeamsAtTheirBearings) {
  const Pose2 T_base_camera{0.1, -0.2, 0.3};
  const DepthView view(*laser(), T_base_camera);
  EXPECT_EQ(view.stamp, Timestamp(std::chrono::seconds(7)));
  EXPECT_EQ(view.T_base_depth, T_base_camera);
  ASSERT_EQ(view.beams.size(), 3U);
  const float bearings[] = {-0.50F, -0.48F, -0.47F}, ranges[] = {2.0F, 3.0F, 1.0F}, from[] = {0.6F, 0.7F, 1.0F};
  const bool hits[] = {true, false, true};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(view.beams[i].bearing, bearings[i], 1e-6F);
    EXPECT_EQ(view.beams[i].range, ranges[i]);
    EXPECT_EQ(view.beams[i].free_from, from[i]);
    EXPECT_EQ(view.beams[i].hit, hits[i]);
  }
}

TEST(DepthView, KeepsTheSurfacesBehindAtTheirBearings) {
  const DepthView view(*laser(), {});
  ASSERT_EQ(view.surfaces.size(), 2U);
  EXPECT_NEAR(view.surfaces[0].bearing, -0.48F, 1e-6F);
  EXPECT_NEAR(view.surfaces[1].bearing, -0.47F, 1e-6F);
  EXPECT_EQ(view.surfaces[0].from, 3.1F);
  EXPECT_EQ(view.surfaces[0].to, 3.4F);
}

TEST(PseudoLaser, TakesSurfacesUntilItIsFull) {
  auto full = laser();
  int taken = full->surface_count;
  while (full->push({.beam = 1, .from = 1.0F, .to = 2.0F}) && taken < 10'000) ++taken;
  EXPECT_EQ(taken, PseudoLaser::kSurfaceCapacity);
  EXPECT_EQ(full->surfaces().size(), static_cast<std::size_t>(PseudoLaser::kSurfaceCapacity));
}

}  // namespace
}  // namespace slam::depth_view_test
