// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/slamd_base/base_control.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace slamd_base {
namespace {

constexpr std::uint32_t kPeriod = 10000;  // [us]
constexpr ControlGains kGains{3000.0F, 0.8F, 4.0F};

/// Two motors with inertia and friction on one supply. Their true full speed is not what the gains have.
struct Motors {
  double full = 2400.0, friction = 0.08, constant = 0.06;  // [counts/s, 1 of the duty, s]
  double speed[2] = {}, position[2] = {};                  // [counts/s, counts]
  std::int32_t counts[2] = {};

  void step(const BaseControl& control, double elapsed) {
    for (int side = 0; side < 2; ++side) {
      const double duty = static_cast<double>(control.duty(static_cast<std::uint8_t>(side)));
      const double drive = std::copysign(std::max(std::abs(duty) - friction, 0.0), duty);
      speed[side] += (full * drive - speed[side]) * elapsed / constant;
      position[side] += speed[side] * elapsed;
      counts[side] = static_cast<std::int32_t>(std::floor(position[side]));
    }
  }
};

struct Rig {
  explicit Rig(std::uint32_t start) : now(start) { control.step(now, motors.counts); }
  /// @param each calls before each step
  template <typename Each>
  void run(double seconds, Each&& each) {
    for (int i = 0; i < static_cast<int>(seconds * 100); ++i) {
      each();
      control.step(now, motors.counts);
      motors.step(control, 0.01);
      now += kPeriod;
    }
  }
  std::uint32_t now;  // [us]
  Motors motors;
  BaseControl control{kGains};
};

TEST(BaseControl, DrivesTheWheelsAtTheSpeedThatIsWanted) {
  for (const std::int32_t speed : {1500, 400, -900}) {
    Rig rig(0);
    rig.run(2.0, [&] { rig.control.command({1, {speed, -speed / 2}}, rig.now); });
    EXPECT_NEAR(rig.motors.speed[0], speed, 0.03 * std::abs(speed));
    EXPECT_NEAR(rig.motors.speed[1], -0.5 * speed, 0.05 * std::abs(speed));
  }
}

TEST(BaseControl, StopsTheMotorsBehindTheLastCommandAlsoWhereItsClockWraps) {
  for (const std::uint32_t start : {0U, 5'000'000U, UINT32_MAX - 350'000U, UINT32_MAX - 1'100'000U}) {
    Rig rig(start);
    rig.run(1.0, [&] { rig.control.command({9, {1000, 1000}}, rig.now); });
    EXPECT_TRUE(rig.control.driven());
    const double lasts = 1e-3 * kCommandLasts;
    rig.run(lasts - 0.02, [] {});
    EXPECT_GT(rig.control.duty(0), 0.0F);
    rig.run(0.03, [] {});
    EXPECT_FALSE(rig.control.driven());
    EXPECT_EQ(rig.control.duty(0), 0.0F);
    EXPECT_EQ(rig.control.duty(1), 0.0F);
    EXPECT_EQ(rig.control.number(), 9) << "what was received stays known";
  }
}

TEST(BaseControl, NeverDrivesOnWhenItsClockHasGoneAround) {
  Rig rig(0);
  rig.control.command({1, {1000, 1000}}, rig.now);
  rig.run(0.5, [] {});
  rig.now = UINT32_MAX;  // 71 minutes later the difference of the stamps is small again
  rig.run(0.1, [&] { EXPECT_EQ(rig.control.duty(0), 0.0F); });
}

TEST(BaseControl, GivesNoCurrentToAMotorThatShallStand) {
  Rig rig(0);
  rig.run(10.0, [] {});
  EXPECT_EQ(rig.control.duty(0), 0.0F) << "before the first command";
  rig.motors.counts[0] = INT32_MAX;  // a counter that wraps is no speed
  rig.control.step(rig.now, rig.motors.counts);
  EXPECT_EQ(rig.control.duty(0), 0.0F);
  rig.run(1.0, [&] { rig.control.command({2, {0, 800}}, rig.now); });
  EXPECT_EQ(rig.control.duty(0), 0.0F);
  EXPECT_GT(rig.control.duty(1), 0.0F);
}

TEST(BaseControl, KeepsTheDutyWithinItsRange) {
  std::mt19937 random(6);
  BaseControl control(kGains);
  std::uint32_t now = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::int32_t counts[2] = {static_cast<std::int32_t>(random()), static_cast<std::int32_t>(random())};
    if (i % 3 == 0)
      control.command({1, {static_cast<std::int32_t>(random()), static_cast<std::int32_t>(random())}}, now);
    control.step(now, counts);
    now += static_cast<std::uint32_t>(random() % 30000);
    for (const std::uint8_t side : {std::uint8_t{0}, std::uint8_t{1}})
      ASSERT_LE(std::abs(control.duty(side)), 1.0F) << "and a number";
  }
}

}  // namespace
}  // namespace slamd_base
