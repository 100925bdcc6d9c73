// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/misfit.hpp"

#include <gtest/gtest.h>

#include "tools/calibrate/motions.hpp"

namespace slam::misfit_test {
namespace {

using test::Drive;
using test::kRobot;
using test::MotionMaker;

TEST(Misfit, ShowsTheNoiseThatTheMotionsHave) {
  for (const double noise : {1.0, 2.0, 5.0}) {
    const auto found = misfits(kRobot, MotionMaker(1, noise).make(Drive::kVaried, 400));
    for (const NoiseScale scale : {robustScale(found), fittedScale(found)}) {
      EXPECT_NEAR(scale.translation / noise, 1.0, 0.15);
      EXPECT_NEAR(scale.rotation / noise, 1.0, 0.15);
    }
  }
}

TEST(Misfit, IsOfThreeDegreesOfFreedom) {
  const auto found = misfits(kRobot, MotionMaker(1).make(Drive::kVaried, 400));
  EXPECT_NEAR(medianMisfit(found), 2.366, 0.4);
  for (const Misfit& misfit : found) EXPECT_NEAR(misfit.all, misfit.translation + misfit.rotation, 1e-9);
}

TEST(NoiseScale, OfTheMedianIgnoresOutliers) {
  auto motions = MotionMaker(1).make(Drive::kVaried, 100);
  for (std::size_t i = 0; i < 30; ++i) MotionMaker::slip(motions[i]);
  const auto found = misfits(kRobot, motions);
  EXPECT_LT(robustScale(found).translation, 2.0);
  EXPECT_GT(fittedScale(found).translation, 4.0);
}

TEST(NoiseScale, IsNeverBelowOne) {
  const auto found = misfits(kRobot, MotionMaker(1, 0.0).make(Drive::kVaried, 50));
  EXPECT_DOUBLE_EQ(robustScale(found).rotation, 1.0);
  EXPECT_DOUBLE_EQ(fittedScale(found).translation, 1.0);
}

TEST(NoiseScale, MakesTheMisfitsThoseOfOrdinaryNoise) {
  const auto motions = MotionMaker(1, 4.0).make(Drive::kVaried, 400);
  const auto level = scaled(motions, robustScale(misfits(kRobot, motions)));
  EXPECT_NEAR(medianMisfit(misfits(kRobot, level)), 2.366, 0.4);
}

TEST(Residual, IsZeroForTheTruthAndWrapsTheTurn) {
  LidarMotion motion = MotionMaker(1, 0.0).make(Drive::kOnTheSpot, 1).front();
  EXPECT_LT(residual(kRobot, motion).norm(), 1e-12);
  motion.T_begin_end.theta += 6.28;
  EXPECT_NEAR(residual(kRobot, motion).z(), 6.28 - 2.0 * 3.14159265358979, 1e-9);
}

}  // namespace
}  // namespace slam::misfit_test
