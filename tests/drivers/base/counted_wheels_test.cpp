// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/counted_wheels.hpp"

#include <gtest/gtest.h>
#include <random>

namespace slam::counted_wheels_test {
namespace {

using namespace std::chrono_literals;
using Counts = std::array<std::uint32_t, 2>;

constexpr Timestamp kStart{100s};
constexpr double kTurn = 2.0 * std::numbers::pi;

TEST(CountedWheels, AddUpAcrossEachWrap) {
  for (const int bits : {16, 32}) {
    std::mt19937 random(5);
    std::uniform_int_distribution<int> step(-400, 400);
    CountedWheels wheels(1000.0, bits, 100.0);
    const std::uint32_t mask = bits == 16 ? 0xFFFFU : 0xFFFFFFFFU;
    std::int64_t left = 0xFFFFFF00LL, right = -5;
    const std::int64_t left0 = left, right0 = right;
    WheelAngles angles;
    for (int i = 0; i < 5000; ++i) {
      const Counts counts{static_cast<std::uint32_t>(left) & mask, static_cast<std::uint32_t>(right) & mask};
      angles = wheels.add(kStart + i * 20ms, counts, false);
      EXPECT_EQ(angles.restarted, i == 0);
      EXPECT_NEAR(angles.angles[0], kTurn * static_cast<double>(left - left0) / 1000.0, 1e-6);
      EXPECT_NEAR(angles.angles[1], kTurn * static_cast<double>(right - right0) / 1000.0, 1e-6);
      left += step(random) + 40;
      right += step(random) - 40;
    }
    EXPECT_EQ(angles.count, 2);
  }
}

TEST(CountedWheels, BeginAnewBehindAJumpAndBehindASilenceInWhichTheBaseMayHaveBeenReset) {
  CountedWheels wheels(1000.0, 16, 50.0);
  wheels.add(kStart, {100, 100}, false);
  EXPECT_FALSE(wheels.add(kStart + 20ms, {200, 200}, false).restarted);
  const WheelAngles jumped = wheels.add(kStart + 40ms, {20000, 200}, false);
  EXPECT_TRUE(jumped.restarted);
  EXPECT_NEAR(jumped.angles[0], kTurn * 0.1, 1e-9) << "the angles go on from where they were";
  EXPECT_FALSE(wheels.add(kStart + 60ms, {20010, 210}, false).restarted);
  EXPECT_FALSE(wheels.add(kStart + 550ms, {21000, 1000}, false).restarted);
  EXPECT_TRUE(wheels.add(kStart + 1100ms, {21100, 1100}, false).restarted);
  EXPECT_TRUE(wheels.add(kStart + 1000ms, {21100, 1100}, false).restarted) << "a stamp that goes back";
}

TEST(CountedWheels, StandWhileAWheelHangsInTheAir) {
  CountedWheels wheels(1000.0, 16, 50.0);
  wheels.add(kStart, {0, 0}, false);
  wheels.add(kStart + 20ms, {100, 100}, false);
  const WheelAngles lifted = wheels.add(kStart + 40ms, {250, 250}, true);
  EXPECT_TRUE(lifted.lifted);
  EXPECT_NEAR(lifted.angles[0], kTurn * 0.1, 1e-9);
  EXPECT_NEAR(wheels.add(kStart + 60ms, {400, 400}, true).angles[0], kTurn * 0.1, 1e-9);
  EXPECT_NEAR(wheels.add(kStart + 80ms, {450, 450}, false).angles[0], kTurn * 0.1, 1e-9)
      << "when it was put down between these two is not known";
  EXPECT_NEAR(wheels.add(kStart + 100ms, {550, 550}, false).angles[0], kTurn * 0.2, 1e-9);
}

}  // namespace
}  // namespace slam::counted_wheels_test
