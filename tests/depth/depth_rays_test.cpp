// SPDX-License-Identifier: BSD-3-Clause
#include "depth/depth_rays.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace slam::depth_rays_test {
namespace {

constexpr double kStep = 0.0087;
const DepthIntrinsics kXtion = DepthIntrinsics::fromFieldOfView(320, 240, 1.0226, 0.7966);

DepthRays raysOf(const DepthExtrinsics& extrinsics) {
  DepthRays rays;
  rays.prepare(extrinsics, kXtion, kStep, 1024);
  return rays;
}

std::size_t index(int u, int v) { return static_cast<std::size_t>(v * kXtion.width + u); }

TEST(DepthRays, CoverTheFieldOfViewFromRightToLeft) {
  const DepthRays rays = raysOf({.z = 0.4});
  EXPECT_NEAR(static_cast<double>(rays.beams()) * rays.bearingStep(), 1.0226, 0.01);
  EXPECT_LT(rays.bearingMin(), 0.0F);
  EXPECT_EQ(rays.pixel(index(319, 120)).beam, 0) << "the image's right is the robot's right";
  EXPECT_EQ(rays.pixel(index(0, 120)).beam, rays.beams() - 1);
}

TEST(DepthRays, PixelsAndBandsLieWhereThePinholeModelPutsThem) {
  const DepthRays rays = raysOf({.z = 0.4});
  const auto& low = rays.pixel(index(160, 239));
  EXPECT_NEAR(low.up, (kXtion.cy - 239) / kXtion.fy, 1e-6);
  EXPECT_NEAR(low.across, 1.0, 1e-4);
  EXPECT_EQ(rays.bandOfRow(239), DepthRays::kBands - 1U);
  const auto& band = rays.bands(low.beam)[DepthRays::kBands - 1];
  EXPECT_GT(band.pixels, 0);
  EXPECT_LE(band.slope_low, low.up / low.across + 1e-6F);
  EXPECT_GE(band.slope_high, low.up / low.across - 1e-6F);
}

TEST(DepthRays, APitchedCameraIsLevelled) {
  constexpr double kPitch = 0.2;
  const DepthRays rays = raysOf({.z = 0.4, .pitch = kPitch});
  const auto& middle = rays.pixel(index(160, 120));
  const double slope = std::tan(std::atan2(kXtion.cy - 120, kXtion.fy) - kPitch);
  EXPECT_NEAR(middle.up / middle.across, slope, 1e-3) << "a positive pitch looks down";
}

TEST(DepthRays, RowsAreBoundedAndCutIntoRunsOfOneBeam) {
  for (const DepthExtrinsics& extrinsics :
       {DepthExtrinsics{.z = 0.4}, DepthExtrinsics{.z = 0.4, .roll = 0.3, .pitch = 0.4}}) {
    const DepthRays rays = raysOf(extrinsics);
    for (int v = 0; v < kXtion.height; ++v) {
      const DepthRays::Row& row = rays.row(static_cast<std::size_t>(v));
      int u = 0;
      for (const DepthRays::Run& run : rays.runs(row)) {
        ASSERT_GT(run.end, u);
        for (; u < run.end; ++u) {
          const DepthRays::Pixel& pixel = rays.pixel(index(u, v));
          ASSERT_EQ(pixel.beam, run.beam) << u << ", " << v;
          ASSERT_TRUE(pixel.across >= row.across_low && pixel.across <= row.across_high) << u << ", " << v;
          ASSERT_TRUE(pixel.up >= row.up_low && pixel.up <= row.up_high) << u << ", " << v;
        }
      }
      ASSERT_EQ(u, kXtion.width);
    }
  }
}

TEST(DepthRays, MakeNoMoreBeamsThanThereIsRoomFor) {
  DepthRays rays;
  rays.prepare({.z = 0.4}, kXtion, kStep, 20);
  EXPECT_EQ(rays.beams(), 20);
}

}  // namespace
}  // namespace slam::depth_rays_test
