// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/wheel_odometry.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>

#include "core/plausibility.hpp"
#include "support/absurd.hpp"

namespace slam::wheel_odometry_test {
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

TEST(WheelOdometry, DrivesAMecanumBaseSideways) {
  constexpr BaseKinematics base{BaseType::kMecanum4, 0.0485, 0.199};
  WheelOdometry odometry(base);
  odometry.add(WheelVector{7.0, -8.0, 9.0, 1e4});
  const WheelVector turned = wheelsOf(base, {0.0, 1.5, 0.0});
  expectSame(odometry.add(WheelVector{7.0 + turned[0], -8.0 + turned[1], 9.0 + turned[2], 1e4 + turned[3]}),
             {0.0, 1.5, 0.0}, 1e-11);
}

TEST(WheelOdometry, FollowsTheArcOfAnyBase) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(-0.5, 0.5);
  for (const BaseKinematics& base :
       {BaseKinematics{BaseType::kOmni3, 0.032, 0.1025}, BaseKinematics{BaseType::kMecanum4, 0.0485, 0.199}}) {
    WheelOdometry odometry(base);
    WheelVector angles{};
    const auto used = std::span(angles).first(static_cast<std::size_t>(wheelCount(base.type)));
    odometry.add(used);
    Pose2 expected;
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d step{any(random), any(random), any(random)};
      const WheelVector turned = wheelsOf(base, step);
      for (std::size_t k = 0; k < angles.size(); ++k) angles[k] += turned[k];
      expected = expected * exp(step);
      expectSame(odometry.add(used), expected, 1e-9);
    }
  }
}

TEST(WheelOdometry, HintsAtSlipOnlyWhereWheelsContradictEachOther) {
  WheelOdometry odometry(BaseKinematics{BaseType::kMecanum4, 0.05, 0.2});
  odometry.add(WheelVector{});
  odometry.add(WheelVector{-1.0, 1.0, 1.0, -1.0});
  EXPECT_NEAR(odometry.slip(), 0.0, 1e-15);
  odometry.add(WheelVector{-1.0, 1.0, 1.0, -0.6});
  EXPECT_NEAR(odometry.slip(), 0.1 * 0.05, 1e-15);
}

TEST(WheelOdometry, ReadsTwoAxlesAsTheirMean) {
  WheelOdometry two(kBase), four(kBase);
  two.add(0, 0);
  four.add(WheelVector{});
  expectSame(four.add(WheelVector{0.9, 2.2, 1.1, 1.8}), two.add(1.0, 2.0));
}

TEST(WheelOdometry, InventsNoMotionFromReadingsThatAreNone) {
  WheelOdometry odometry(kBase);
  odometry.add(0, 0);
  const Pose2 before = odometry.add(3, 4);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(odometry.add(bad, 4), before);
    EXPECT_EQ(odometry.add(500, 4), before) << "nothing to compare with";
  }
  EXPECT_EQ(odometry.add(std::array{1.0, 2.0, 3.0}), before);
}

TEST(WheelOdometry, GoesOnBehindAnglesThatNoWheelHas) {
  WheelOdometry odometry(kBase);
  Pose2 before;
  for (const double bad : test::absurdNumbers(kPlausible.dead_reckoned)) {
    odometry.add(1.0, 1.0);
    before = odometry.add(1.1, 1.1);
    EXPECT_EQ(odometry.add(bad, 1.1), before) << bad;
    EXPECT_EQ(odometry.add(2.0, 2.0), before) << bad;
    EXPECT_NE(odometry.add(2.1, 2.1), before) << bad;
    EXPECT_LT(std::hypot(odometry.pose().x, odometry.pose().y), 10.0) << bad;
  }
}

// What single precision costs. The firmware adds up degrees in single precision at 50 Hz and sends radians in the same
// [OpenRE, 2_Package/motor/motor_control.cpp, 2_Package/robot_control/chassis.cpp].
struct FloatCounter {
  double turned;  // [rad] long ago
  double worst;   // [m] by which 10 m are off
};
class LongRun : public testing::TestWithParam<FloatCounter> {};

TEST_P(LongRun, OfASinglePrecisionCounterCostsLittleUntilItIsVeryLong) {
  constexpr double kCount = 2 * std::numbers::pi / 1560;  // [rad] of one encoder count
  const auto degrees = static_cast<float>(GetParam().turned * 180 / std::numbers::pi);
  float left = degrees, right = degrees;  // [deg]
  WheelOdometry exact(kBase), counted(kBase);
  double left_angle = 0, right_angle = 0;  // [rad]
  const auto radians = [](float value) { return static_cast<double>(value * 0.017453293F); };
  exact.add(0, 0);
  counted.add(radians(left), radians(right));
  for (int i = 0; i < 50 * 40; ++i) {  // 40 s at 0.25 m/s, wheels a little different
    const int dl = static_cast<int>((i + 1) * 31.05) - static_cast<int>(i * 31.05);
    const int dr = static_cast<int>((i + 1) * 31.07) - static_cast<int>(i * 31.07);
    left += static_cast<float>(dl) / 1560.0F * 360.0F;
    right += static_cast<float>(dr) / 1560.0F * 360.0F;
    exact.add(left_angle += dl * kCount, right_angle += dr * kCount);
    counted.add(radians(left), radians(right));
  }
  const Pose2 error = between(exact.pose(), counted.pose());
  EXPECT_LT(error.translation().norm(), GetParam().worst);
  RecordProperty("error_um", static_cast<int>(1e6 * error.translation().norm()));
  RecordProperty("heading_urad", static_cast<int>(1e6 * error.theta));
}

INSTANTIATE_TEST_SUITE_P(Of, LongRun,
                         testing::Values(FloatCounter{0, 1e-3}, FloatCounter{2048, 5e-3}, FloatCounter{8192, 1e-2},
                                         FloatCounter{65536, 2e-1}));

}  // namespace
}  // namespace slam::wheel_odometry_test
