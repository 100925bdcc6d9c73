// SPDX-License-Identifier: BSD-3-Clause
// The speeds that CanBase sends, apart from what it receives.
#include <atomic>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <thread>

#include "drivers/can/can_base_fixture.hpp"
#include "runtime/clock.hpp"

namespace slam::can_base_commands_test {
namespace {

using namespace std::chrono_literals;
namespace odrive = can::odrive;
using testing::HasSubstr;

constexpr double kTurn = 2.0 * std::numbers::pi;

/// Of a base on which a wheel turns 1 rad for each metre, and a turn of 1 rad is half a radian of each.
CanBaseConfig commanding(const CanWheelsConfig& wheel = {}) {
  return {.wheel = wheel, .commands = true, .wheel_radius = 1.0, .half_track = 0.5, .limits = {1000.0, 1000.0}};
}

/// That makes the wheels turn so fast [rad/s].
Twist2 twist(double left, double right) { return {(left + right) / 2.0, 0.0, right - left}; }

class CanBaseCommands : public test::CanBaseTest {
 protected:
  /// @return [turns/s] that each drive was sent last
  std::array<float, 2> lastSpeeds() const {
    std::array<float, 2> speeds{};
    for (const can::Frame& frame : bus_.sent) {
      for (std::size_t side = 0; side < 2; ++side) {
        const auto velocity = odrive::parseInputVelocity(nodes_[side], frame);
        if (velocity) speeds[side] = velocity->velocity;
      }
    }
    return speeds;
  }
  /// The wheels turn as they are sent.
  void driveFor(Duration time, const Twist2& wanted) {
    for (const Timestamp end = bus_.clock + time; bus_.clock < end;) {
      driver_->command(wanted);
      runFor(5ms);
      for (std::size_t side = 0; side < 2; ++side) speed_[side] = deaf_[side] ? 0.0F : lastSpeeds()[side];
    }
  }
  bool drives() const { return lastSpeeds()[0] != 0.0F && lastSpeeds()[1] != 0.0F; }
  bool stands() const { return lastSpeeds() == std::array<float, 2>{}; }
  std::array<bool, 2> deaf_{};  // the drive leaves speeds out

  void expectOnlyZeros() {
    std::size_t speeds = 0;
    for (const can::Frame& frame : bus_.sent) {
      for (const int node : nodes_) {
        const auto velocity = odrive::parseInputVelocity(node, frame);
        if (!velocity) continue;
        EXPECT_EQ(velocity->velocity, 0.0F);
        ++speeds;
      }
    }
    EXPECT_GE(speeds, 2U);
  }
};

TEST_F(CanBaseCommands, SendsNothingUnlessCommandsAreSwitchedOnAndTheWheelsAreItsOwn) {
  for (const CanBaseConfig& config : {CanBaseConfig{}, CanBaseConfig{.wheels = false, .commands = true}}) {
    start(config);
    driver_->command({.vx = 0.1});
    runFor(1s);
    driver_->stop();
    EXPECT_TRUE(bus_.sent.empty());
  }
}

TEST_F(CanBaseCommands, SendsSpeedsAt50HzWhileTheyAreFresh) {
  start(commanding({.sign = {1.0, -1.0}, .gear_ratio = 2.0}));
  runFor(1s);
  EXPECT_NEAR(static_cast<int>(bus_.sent.size()), 2 * 50, 4);
  expectOnlyZeros();
  bus_.sent.clear();
  driver_->command(twist(kTurn, -kTurn / 2.0));
  runFor(60s);
  int driving = 0, stopping = 0;
  for (const can::Frame& frame : bus_.sent) {
    const bool left = frame.id == 0x20D;
    const auto velocity = odrive::parseInputVelocity(left ? 0x10 : 0x18, frame);
    ASSERT_TRUE(velocity);
    EXPECT_EQ(velocity->torque, 0.0F);
    if (velocity->velocity == 0.0F) {
      ++stopping;
      continue;
    }
    ++driving;
    EXPECT_EQ(stopping, 0) << "no speed after the first zero";
    EXPECT_FLOAT_EQ(velocity->velocity, left ? 2.0F : 1.0F);
  }
  EXPECT_NEAR(driving, 2 * 22, 4) << "less than half a second";
  EXPECT_NEAR(stopping, 2 * 2978, 4) << "zeros from then on";
}

TEST_F(CanBaseCommands, SendsZeroAtTheEnd) {
  start({.commands = true});
  runFor(100ms);
  driver_->command({.vx = 0.1});
  runFor(100ms);
  driver_->stop();
  bus_.sent.erase(bus_.sent.begin(), bus_.sent.end() - 2);
  expectOnlyZeros();
}

TEST_F(CanBaseCommands, DoesNotSendWhatIsNotANumber) {
  start({.commands = true});
  runFor(500ms);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(driver_->command({.vx = bad}));
    EXPECT_FALSE(driver_->command({.omega = bad}));
  }
  runFor(100ms);
  expectOnlyZeros();
}

TEST_F(CanBaseCommands, SendsWhatIsTooFastSlowerOnTheSameCurve) {
  start({.wheel = {.max_speed = 10.0}, .commands = true, .wheel_radius = 0.1, .half_track = 0.5, .limits = {0.8, 2.0}});
  for (const Twist2& wanted : {Twist2{1e300, 0.0, 1e300}, Twist2{40.0, 0.0, 40.0}, Twist2{0.9, 0.0, 0.9}}) {
    driveFor(500ms, wanted);
    // 0.8 m/s and 0.8 rad/s turn the right wheel at 12 rad/s, which is above 10.
    EXPECT_NEAR(lastSpeeds()[1] * kTurn, 10.0, 1e-4);
    EXPECT_NEAR(lastSpeeds()[0] * kTurn, 10.0 / 3.0, 1e-4) << "the curve stays";
  }
  EXPECT_GT(driver_->limitedSpeeds(), 200U);
}

// ---- A base whose wheels do not all obey

TEST_F(CanBaseCommands, StopsBothWheelsWhileOneDriveDoesNotObey) {
  struct {
    odrive::Heartbeat heartbeat;
    const char *words, *fix;
  } const cases[] = {{{.state = 1}, "is not in closed loop", "cansend can0 307#08000000"},
                     {{.axis_error = 0x40, .state = 1, .motor_error = true}, "axis error 0x40", "cansend can0 318#"},
                     {{.axis_error = 0x40, .state = 8}, "axis error 0x40", "cansend can0 318#"},
                     {{.state = 4}, "is not in closed loop", "cansend can0 307#08000000"}};
  for (const auto& [heartbeat, words, fix] : cases) {
    heartbeat_[1] = {.state = 8};
    start({.commands = true});
    driveFor(1s, {.vx = 0.1});
    ASSERT_TRUE(drives());
    EXPECT_EQ(wheelReason(), "");
    heartbeat_[1] = heartbeat;
    deaf_[1] = true;
    driveFor(250ms, {.vx = 0.1});
    EXPECT_TRUE(stands()) << words;
    EXPECT_EQ(wheelState(), DeviceState::kFault);
    EXPECT_THAT(wheelReason(), testing::AllOf(HasSubstr("right wheel"), HasSubstr(words), HasSubstr(fix),
                                              HasSubstr("slamd stops both wheels")));
    bus_.sent.clear();
    driveFor(10s, {.vx = 0.1});
    EXPECT_GE(bus_.sent.size(), 900U) << "their watchdogs are fed";
    expectOnlyZeros();
    heartbeat_[1] = {.state = 8};
    deaf_[1] = false;
    runFor(300ms);
    EXPECT_TRUE(stands()) << "what was given before is not driven";
    EXPECT_EQ(wheelState(), DeviceState::kStreaming) << wheelReason();
    driveFor(100ms, {.vx = 0.1});
    EXPECT_TRUE(drives());
  }
}

TEST_F(CanBaseCommands, StopsAtTheFirstHeartbeatThatReportsAnIdleDrive) {
  start({.commands = true});
  driveFor(1s, {.vx = 0.1});
  bus_.put(odrive::encodeHeartbeat(nodes_[0], {.state = 1}));
  driveFor(10ms, {.vx = 0.1});
  EXPECT_TRUE(stands());
  EXPECT_EQ(wheelState(), DeviceState::kStreaming) << "it may have been damaged";
  driveFor(300ms, {.vx = 0.1});
  EXPECT_TRUE(drives());
}

TEST_F(CanBaseCommands, StopsBothWheelsWhileADriveSendsNoHeartbeats) {
  for (const bool estimates : {true, false}) {
    start({.commands = true});
    driveFor(1s, {.vx = 0.1});
    ASSERT_TRUE(drives());
    heartbeats_ = false;
    drive_[0] = estimates;
    driveFor(450ms, {.vx = 0.1});
    EXPECT_TRUE(stands());
    driveFor(200ms, {.vx = 0.1});
    EXPECT_NE(wheelState(), DeviceState::kStreaming);
    EXPECT_THAT(wheelReason(), testing::AllOf(HasSubstr("left wheel"), HasSubstr("slamd stops both wheels")));
    heartbeats_ = drive_[0] = true;
    driveFor(300ms, {.vx = 0.1});
    EXPECT_TRUE(drives());
  }
}

TEST_F(CanBaseCommands, WaitsForHeartbeatsAsLongAsTheDriveLetsItWait) {
  start({.commands = true});
  const auto runSlowly = [&](Duration time) {
    for (const Timestamp end = bus_.clock + time; bus_.clock < end;) {
      heartbeats_ = (step_ + 1) % 160 == 0;  // each 0.8 s
      driveFor(5ms, {.vx = 0.1});
    }
  };
  runSlowly(5s);
  for (int i = 0; i < 100; ++i) {
    runSlowly(50ms);
    ASSERT_TRUE(drives());
  }
}

TEST_F(CanBaseCommands, DrivesNothingBeforeBothDrivesAreKnownToObey) {
  heartbeats_ = false;
  start({.commands = true});
  driveFor(2s, {.vx = 0.1});
  expectOnlyZeros();
  EXPECT_THAT(wheelReason(),
              testing::AllOf(HasSubstr("no heartbeat of the left wheel"), HasSubstr("heartbeat_msg_rate_ms")));
}

TEST_F(CanBaseCommands, StopsBothWheelsWhenOneLeavesItsSpeedOutAlthoughItIsInClosedLoop) {
  start({.commands = true});
  driveFor(1s, {.vx = 0.1});
  ASSERT_TRUE(drives());
  deaf_[0] = true;  // in torque or position control
  driveFor(450ms, {.vx = 0.1});
  EXPECT_TRUE(stands());
  EXPECT_EQ(wheelState(), DeviceState::kFault);
  EXPECT_THAT(wheelReason(), testing::AllOf(HasSubstr("left wheel (node 0x10) does not turn"),
                                            HasSubstr("cansend can0 20b#0200000001000000")));
  bus_.sent.clear();
  driveFor(10s, {.vx = 0.1});
  expectOnlyZeros();
  runFor(2500ms);
  EXPECT_EQ(wheelState(), DeviceState::kStreaming) << "who drove has let go";
  deaf_[0] = false;
  driveFor(1s, {.vx = 0.1});
  EXPECT_TRUE(drives());
}

// ---- Adapters that take no frames

TEST_F(CanBaseCommands, ReportsWithinATenthOfASecondThatTheAdapterTakesNoFrames) {
  for (const int error : {ENOBUFS, EIO, ENETDOWN, EPERM, ENXIO}) {
    start({.commands = true});
    driveFor(1s, {.vx = 0.1});
    ASSERT_EQ(wheelState(), DeviceState::kStreaming);
    bus_.send_error = error;
    driveFor(105ms, {.vx = 0.1});
    for (int i = 0; i < 1000; ++i) {
      EXPECT_EQ(wheelState(), DeviceState::kFault) << error;
      ASSERT_THAT(wheelReason(), testing::AllOf(HasSubstr("can0 takes no frames"), HasSubstr("watchdogs")));
      driveFor(5ms, {.vx = 0.1});
    }
    const CanLinkCounters& counters = driver_->linkCounters();
    EXPECT_GT(error == ENOBUFS ? counters.queue_full : counters.send_errors, 200U);
    EXPECT_EQ(counters.opened > 1, error != ENOBUFS) << "a new socket may help";
    const auto before = wheels_.size();
    runFor(100ms);
    EXPECT_GE(wheels_.size(), before + 8) << "the wheels are still measured";
    bus_.send_error = 0;
    runFor(50ms);
    EXPECT_EQ(wheelState(), DeviceState::kStreaming) << wheelReason();
  }
}

TEST_F(CanBaseCommands, SendsNoOldSpeedsAfterTheQueueWasFull) {
  start({.commands = true});
  runFor(100ms);
  bus_.send_error = ENOBUFS;
  bus_.sent.clear();
  driver_->command({.vx = 0.1});
  runFor(2s);
  bus_.send_error = 0;
  runFor(1s);
  expectOnlyZeros();
  EXPECT_GT(driver_->linkCounters().queue_full, 20U);
}

TEST_F(CanBaseCommands, SendsNoSpeedThatBecameOldWhileItWaitedForRoom) {
  start({.commands = true});
  runFor(100ms);
  driver_->command({.vx = 0.1});
  runFor(430ms);
  bus_.send_error = ENOBUFS;
  runFor(20ms);
  bus_.send_error = 0;
  bus_.sent.clear();
  runFor(100ms);
  expectOnlyZeros();
}

TEST_F(CanBaseCommands, NeverMixesTheSpeedsOfTwoCommands) {
  CanBase driver(commanding(), monotonicNow, {}, std::make_unique<test::FakeCanPort>(bus_));
  std::atomic<bool> done{false};
  std::thread commander([&] {
    for (int i = 0; !done; i = (i + 1) % 50) driver.command(twist(i, -i));
  });
  for (const Timestamp end = monotonicNow() + 20s; bus_.sent.size() < 40 && monotonicNow() < end;) {
    for (const int node : nodes_)
      bus_.incoming.push_back({odrive::encodeHeartbeat(node, {.state = 8}), monotonicNow()});
    driver.tick();
  }
  done = true;
  commander.join();
  ASSERT_GE(bus_.sent.size(), 40U);
  for (std::size_t i = 0; i + 1 < bus_.sent.size(); i += 2) {
    const auto left = odrive::parseInputVelocity(0x10, bus_.sent[i]);
    const auto right = odrive::parseInputVelocity(0x18, bus_.sent[i + 1]);
    ASSERT_TRUE(left && right);
    EXPECT_EQ(left->velocity, -right->velocity);
  }
}

}  // namespace
}  // namespace slam::can_base_commands_test
