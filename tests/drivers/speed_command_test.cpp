// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/speed_command.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace slam::speed_command_test {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kNow{1000s};

TEST(SpeedCommand, LastsForLessThanHalfASecond) {
  SpeedCommand command({});
  EXPECT_FALSE(command.at(kNow));
  ASSERT_TRUE(command.give({0.5, 0.25, -1.0}, kNow));
  for (const Duration age : {0ms, 450ms}) {
    const auto twist = command.at(kNow + age);
    ASSERT_TRUE(twist);
    EXPECT_EQ(twist->vx, 0.5);
    EXPECT_EQ(twist->vy, 0.25);
    EXPECT_EQ(twist->omega, -1.0);
  }
  EXPECT_FALSE(command.at(kNow + 451ms));
  EXPECT_EQ(command.given(), kNow);
}

TEST(SpeedCommand, IsNotDrivenOnceItWasRevoked) {
  SpeedCommand command({});
  command.give({.vx = 0.5}, kNow);
  command.revoke(kNow + 100ms);
  EXPECT_FALSE(command.at(kNow + 100ms));
  command.give({.vx = 0.5}, kNow + 90ms);  // on its way meanwhile
  EXPECT_FALSE(command.at(kNow + 110ms));
  command.give({.vx = 0.5}, kNow + 101ms);
  EXPECT_TRUE(command.at(kNow + 110ms));
}

TEST(SpeedCommand, RefusesWhatIsNotFinite) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  SpeedCommand command({});
  command.give({.vx = 0.5}, kNow);
  for (const double bad : {kNan, kInf, -kInf}) {
    EXPECT_FALSE(command.give({.vx = bad}, kNow + 1ms));
    EXPECT_FALSE(command.give({.vy = bad}, kNow + 1ms));
    EXPECT_FALSE(command.give({.omega = bad}, kNow + 1ms));
  }
  EXPECT_EQ(command.at(kNow + 1ms)->vx, 0.5) << "what was there before stays";
  EXPECT_EQ(command.limited(), 0U);
}

TEST(SpeedCommand, IsWithinItsLimitsOnTheCurveThatWasAskedForWhateverThatIs) {
  const SpeedLimits limits{.max_speed = 0.8, .max_turn_rate = 1.5};
  SpeedCommand command(limits);
  constexpr double kSizes[] = {0.0, 1e-300, 1e-9, 0.1,  0.5,  0.79,   0.81,  1.0,   1.49,   1.51,
                               2.0, 50.0,   1e6,  1e16, 1e38, 3.5e38, 1e155, 1e300, 1.7e308};
  std::uint64_t above = 0;
  for (const double vx : kSizes) {
    for (const double vy : kSizes) {
      for (const double omega : kSizes) {
        const Twist2 wanted{vx, -vy, omega};
        ASSERT_TRUE(command.give(wanted, kNow));
        const Twist2 driven = *command.at(kNow);
        EXPECT_LE(std::hypot(driven.vx, driven.vy), 0.8 + 1e-12);
        EXPECT_LE(std::abs(driven.omega), 1.5 + 1e-12);
        EXPECT_TRUE(std::isfinite(static_cast<float>(driven.vx)) && std::isfinite(static_cast<float>(driven.omega)));
        const bool within = std::hypot(vx, vy) <= 0.8 && omega <= 1.5;
        above += within ? 0 : 1;
        ASSERT_EQ(command.limited(), above);
        if (within) {
          EXPECT_EQ(driven.vx, vx);
          EXPECT_EQ(driven.omega, omega);
          continue;
        }
        const double factor = limits.factor(wanted);
        EXPECT_DOUBLE_EQ(driven.vx, factor * vx) << "one factor for all";
        EXPECT_DOUBLE_EQ(driven.vy, -factor * vy);
        EXPECT_DOUBLE_EQ(driven.omega, factor * omega);
      }
    }
  }
  command.give({.vx = 3.0, .omega = 0.5}, kNow);
  EXPECT_NEAR(command.at(kNow)->vx / command.at(kNow)->omega, 6.0, 1e-12) << "the radius stays";
  command.give({.vx = 0.3, .vy = 0.4, .omega = -15.0}, kNow);
  EXPECT_NEAR(command.at(kNow)->vx, 0.03, 1e-12);
  EXPECT_NEAR(command.at(kNow)->vy, 0.04, 1e-12);
  EXPECT_NEAR(command.at(kNow)->omega, -1.5, 1e-12);
}

TEST(SpeedDuty, OwesAZeroBehindEachSpeedUntilItIsAcknowledged) {
  SpeedDuty duty(true, {}, 50ms);
  EXPECT_FALSE(duty.due(kNow)) << "nothing was sent, and nothing is owed";
  ASSERT_TRUE(duty.give({.vx = 0.3}, kNow));
  ASSERT_EQ(duty.due(kNow).value_or(Twist2{}).vx, 0.3);
  duty.acknowledge();
  EXPECT_TRUE(duty.isOwed()) << "the speed was acknowledged, not a zero";
  EXPECT_FALSE(duty.due(kNow + 49ms)) << "between two speeds";
  for (const auto late : {500ms, 550ms, 600ms}) {
    const auto zero = duty.due(kNow + late);
    ASSERT_TRUE(zero);
    EXPECT_EQ(zero->vx, 0.0);
    EXPECT_FALSE(duty.due(kNow + late + 49ms));
  }
  duty.acknowledge();
  EXPECT_FALSE(duty.due(kNow + 700ms));
  duty.owe();
  EXPECT_TRUE(duty.due(kNow + 710ms)) << "an answer did not come, or the base was reset";
}

TEST(SpeedDuty, LetsAFreshCommandGoBeforeTheZeroAndRevokesOldOnes) {
  SpeedDuty duty(true, {}, 50ms);
  duty.owe();
  ASSERT_TRUE(duty.give({.vx = 0.3}, kNow));
  EXPECT_EQ(duty.due(kNow).value_or(Twist2{}).vx, 0.3);
  duty.revoke(kNow + 10ms);
  EXPECT_FALSE(duty.drives(kNow + 10ms));
  EXPECT_EQ(duty.due(kNow + 10ms).value_or(Twist2{.vx = 1.0}).vx, 0.0) << "a stop does not wait";
  ASSERT_TRUE(duty.give({.vx = 0.2}, kNow + 60ms));
  EXPECT_EQ(duty.due(kNow + 60ms).value_or(Twist2{}).vx, 0.2);
}

TEST(SpeedDuty, OwesNothingWhereTheBaseMayNotBeDriven) {
  SpeedDuty duty(false, {}, 50ms);
  duty.owe();
  EXPECT_FALSE(duty.give({.vx = 0.3}, kNow));
  EXPECT_FALSE(duty.isOwed());
  EXPECT_FALSE(duty.due(kNow));
}

}  // namespace
}  // namespace slam::speed_command_test
