// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/wheel_odometry.hpp"

#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace slam {
namespace {

constexpr DifferentialBase kBase{.wheel_radius = 0.04, .half_track = 0.1};

void expectSame(const Pose2& actual, const Pose2& expected, double tolerance = 1e-12) {
  EXPECT_NEAR(actual.x, expected.x, tolerance);
  EXPECT_NEAR(actual.y, expected.y, tolerance);
  EXPECT_NEAR(wrapAngle(actual.theta - expected.theta), 0.0, tolerance);
}

TEST(WheelOdometry, FollowsEachArcExactly) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> radians(-3.0, 3.0);
  WheelOdometry odometry(kBase);
  double left = 100.0, right = -50.0;  // counters start anywhere
  odometry.add(left, right);
  Pose2 expected;
  for (int i = 0; i < 1000; ++i) {
    const double dl = radians(random), dr = i % 10 == 0 ? dl : radians(random);  // straight now and then
    expected = expected * exp(Eigen::Vector3d{0.04 * (dl + dr) / 2, 0, 0.04 * (dr - dl) / 0.2});
    left += dl;
    right += dr;
    expectSame(odometry.add(left, right), expected, 1e-9);
    EXPECT_EQ(odometry.pose(), odometry.add(left, right));  // no motion, no change
  }
}

TEST(WheelOdometry, TheFirstReadingIsTheOrigin) {
  WheelOdometry odometry(kBase);
  EXPECT_EQ(odometry.add(1234.5, -678.9), Pose2{});
}

TEST(WheelOdometry, MissedReadingsLoseNothingAtConstantWheelSpeeds) {
  WheelOdometry all(kBase), few(kBase);
  for (int i = 0; i <= 300; ++i) {
    all.add(0.11 * i, 0.17 * i);
    if (i % 30 == 0) expectSame(few.add(0.11 * i, 0.17 * i), all.pose(), 1e-10);
  }
}

TEST(WheelOdometry, OppositeWheelsTurnOnTheSpotCounterClockwise) {
  WheelOdometry odometry(kBase);
  odometry.add(0, 0);
  const double quarter = std::numbers::pi / 2 * kBase.half_track / kBase.wheel_radius;
  expectSame(odometry.add(-quarter, quarter), {0, 0, std::numbers::pi / 2});
}

TEST(WheelOdometry, GoesOnFromThePresentPoseAfterARestart) {
  WheelOdometry odometry(kBase);
  odometry.add(0, 0);
  const Pose2 before = odometry.add(10, 12);
  odometry.restart();
  EXPECT_EQ(odometry.pose(), before);
  EXPECT_EQ(odometry.add(0, 0), before);
  expectSame(odometry.add(5, 5), before * Pose2{0.2, 0, 0});
}

}  // namespace
}  // namespace slam
