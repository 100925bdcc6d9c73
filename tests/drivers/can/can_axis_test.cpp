// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_axis.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>

namespace slam::can_axis_test {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kStart{1000s};

TEST(CanAxis, AcceptsAHeartbeatThatCameTwice) {
  CanAxis axis;
  EXPECT_FALSE(axis.lastHeartbeat());
  axis.addHeartbeat(kStart, {.state = 8});
  EXPECT_FALSE(axis.lastHeartbeat());
  axis.addHeartbeat(kStart + 100ms, {.state = 8});
  EXPECT_TRUE(axis.inClosedLoop());
  axis.addHeartbeat(kStart + 200ms, {.axis_error = 1, .state = 1});
  EXPECT_FALSE(axis.faulty());
  axis.addHeartbeat(kStart + 300ms, {.axis_error = 1, .state = 1});
  EXPECT_TRUE(axis.faulty());
  EXPECT_FALSE(axis.inClosedLoop());
  EXPECT_EQ(axis.heartbeat(), kStart + 300ms);
}

TEST(CanAxis, ObeysAfterTwoHeartbeatsAndNoLongerWhenOneIsMissing) {
  CanAxis axis;
  Timestamp stamp = kStart;
  const auto obeysAfter = [&](const can::odrive::Heartbeat& heartbeat) {
    axis.addHeartbeat(stamp += 100ms, heartbeat);
    return axis.obeys();
  };
  EXPECT_FALSE(axis.obeys());
  EXPECT_FALSE(obeysAfter({.state = 8}));
  EXPECT_TRUE(obeysAfter({.state = 8}));
  EXPECT_FALSE(obeysAfter({.state = 1}));
  EXPECT_TRUE(obeysAfter({.state = 8})) << "that one was damaged";
  EXPECT_FALSE(obeysAfter({.axis_error = 1, .state = 8}));
  EXPECT_FALSE(obeysAfter({.axis_error = 1, .state = 8}));
  EXPECT_FALSE(obeysAfter({.state = 8}));
  EXPECT_TRUE(obeysAfter({.state = 8}));
}

TEST(CanAxis, MayBeSilentForAsLongAsItsHeartbeatsTake) {
  CanAxis axis;
  EXPECT_EQ(axis.heartbeatPatience(), 300ms);
  for (int i = 0; i < 5; ++i) axis.addHeartbeat(kStart + i * 100ms, {.state = 8});
  EXPECT_EQ(axis.heartbeatPatience(), 300ms);
  for (int i = 1; i < 5; ++i) axis.addHeartbeat(kStart + i * 1s, {.state = 8});
  EXPECT_EQ(axis.heartbeatPatience(), 2250ms);
}

TEST(CanAxis, EachFlagIsAFaultAndOnlyTheEncoderMakesItLie) {
  const auto lies = [](const can::odrive::Heartbeat& heartbeat) {
    CanAxis axis;
    axis.addVersion({.firmware = {0, 5, 6}});
    axis.addHeartbeat(kStart, heartbeat);
    axis.addHeartbeat(kStart + 100ms, heartbeat);
    EXPECT_TRUE(axis.faulty());
    return axis.positionInvalid();
  };
  EXPECT_FALSE(lies({.axis_error = 1}));
  EXPECT_FALSE(lies({.motor_error = true}));
  EXPECT_FALSE(lies({.controller_error = true}));
  EXPECT_TRUE(lies({.encoder_error = true}));
}

class CanAxisDialect : public testing::Test {
 protected:
  void add(int times, std::uint32_t error, std::uint8_t state, std::array<std::uint8_t, 3> rest) {
    for (int i = 0; i < times; ++i, stamp_ += 100ms) {
      can::Frame frame{.id = 0x201, .size = 8};
      for (std::size_t k = 0; k < 4; ++k) frame.data[k] = static_cast<std::uint8_t>(error >> 8 * k);
      frame.data[4] = state;
      std::copy(rest.begin(), rest.end(), frame.data.begin() + 5);
      ASSERT_TRUE(axis_.addHeartbeat(stamp_, 0x10, frame));
    }
  }
  CanAxis axis_;
  Timestamp stamp_ = kStart;
};

TEST_F(CanAxisDialect, LeavesItToTheAxisErrorWhereItIsNotKnown) {
  add(5, 0, 8, {1, 1, 0});
  EXPECT_EQ(axis_.dialect(), CanAxis::Dialect::kUnknown);
  EXPECT_TRUE(axis_.isAmbiguous());
  EXPECT_FALSE(axis_.faulty()) << "0.6 in closed loop";
  EXPECT_FALSE(axis_.positionInvalid());
  add(5, 0x200, 1, {1, 1, 0});
  EXPECT_TRUE(axis_.faulty());
  EXPECT_FALSE(axis_.positionInvalid()) << "a disarmed wheel is measured";
  EXPECT_FALSE(axis_.usableHeartbeat()->motor_error);
}

TEST_F(CanAxisDialect, IsLearnedFromWhatOnlyOneOfThemSends) {
  add(2, 0, 8, {0, 0, 0x80});
  EXPECT_EQ(axis_.dialect(), CanAxis::Dialect::k05);
  add(2, 0, 8, {1, 0, 0x80});
  EXPECT_TRUE(axis_.faulty());
  add(1, 0, 8, {0, 0, 0x80});
  add(3, 0, 8, {1, 1, 0});
  EXPECT_FALSE(axis_.faulty()) << "as it would if 0.6 were loaded into it";
  add(2, 0, 8, {0, 0, 0x80});
  stamp_ += 10s;  // another drive has taken its place
  add(2, 0, 8, {1, 1, 0});
  EXPECT_FALSE(axis_.faulty());
  add(1, 0, 1, {3, 1, 0});
  EXPECT_EQ(axis_.dialect(), CanAxis::Dialect::kUnknown) << "once may be damage";
  add(1, 0, 1, {3, 1, 0});
  EXPECT_EQ(axis_.dialect(), CanAxis::Dialect::k06);
}

TEST_F(CanAxisDialect, FollowsFromTheVersion) {
  axis_.addHeartbeat(stamp_, 0x10, can::odrive::encodeHeartbeat(0x10, {}));
  axis_.addVersion({.firmware = {0, 6, 9}});
  add(3, 0x100, 1, {1, 1, 0});
  EXPECT_TRUE(axis_.faulty());
  EXPECT_FALSE(axis_.positionInvalid()) << "0x100 is the bus's voltage, byte 6 the trajectory";
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
}  // namespace slam::can_axis_test
