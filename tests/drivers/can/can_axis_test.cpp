// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_axis.hpp"

#include <gtest/gtest.h>

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kStart{1000s};

TEST(CanAxis, BelievesAHeartbeatThatCameTwice) {
  CanAxis axis;
  EXPECT_FALSE(axis.said());
  axis.addHeartbeat(kStart, {.state = 8});
  EXPECT_FALSE(axis.said());
  axis.addHeartbeat(kStart + 100ms, {.state = 8});
  EXPECT_TRUE(axis.inClosedLoop());
  axis.addHeartbeat(kStart + 200ms, {.axis_error = 1, .state = 1});
  EXPECT_FALSE(axis.faulty());
  axis.addHeartbeat(kStart + 300ms, {.axis_error = 1, .state = 1});
  EXPECT_TRUE(axis.faulty());
  EXPECT_FALSE(axis.inClosedLoop());
  EXPECT_EQ(axis.heartbeat(), kStart + 300ms);
}

TEST(CanAxis, EachFlagIsAFaultAndOnlyTheEncoderMakesItLie) {
  const auto lies = [](const can::odrive::Heartbeat& heartbeat) {
    CanAxis axis;
    axis.addHeartbeat(kStart, heartbeat);
    axis.addHeartbeat(kStart + 100ms, heartbeat);
    EXPECT_TRUE(axis.faulty());
    return axis.lies();
  };
  EXPECT_FALSE(lies({.axis_error = 1}));
  EXPECT_FALSE(lies({.motor_error = true}));
  EXPECT_FALSE(lies({.controller_error = true}));
  EXPECT_TRUE(lies({.encoder_error = true}));
}

TEST(CanAxis, IsFrozenWhenItTurnsWithoutMoving) {
  CanAxis axis;
  Timestamp stamp = kStart;
  float position = 3.0F;  // [turns]
  const auto feed = [&](float step, float velocity, Duration time) {
    for (const Timestamp end = stamp + time; stamp < end; stamp += 10ms)
      axis.addEstimates(stamp, {position += step, velocity});
    return axis.frozen();
  };
  EXPECT_FALSE(feed(0.01F, 1.0F, 1s));
  EXPECT_FALSE(feed(0.0F, 0.0F, 1s)) << "standing";
  EXPECT_FALSE(feed(0.0F, 1.0F, 200ms)) << "may be a coarse encoder";
  EXPECT_TRUE(feed(0.0F, 1.0F, 200ms));
  EXPECT_FALSE(feed(0.01F, 1.0F, 10ms));
}

}  // namespace
}  // namespace slam
