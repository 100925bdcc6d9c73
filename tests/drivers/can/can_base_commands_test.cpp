// SPDX-License-Identifier: BSD-3-Clause
// The speeds that CanBase sends, apart from what it receives.
#include <atomic>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <thread>

#include "drivers/can/can_base_fixture.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
namespace odrive = can::odrive;

constexpr double kTurn = 2.0 * std::numbers::pi;

class CanBaseCommands : public test::CanBaseTest {
 protected:
  void expectOnlyZeros() {
    ASSERT_GE(bus_.sent.size(), 2U);
    for (const can::Frame& frame : bus_.sent)
      EXPECT_EQ(odrive::parseInputVelocity(frame.id == 0x20D ? 0x10 : 0x18, frame)->velocity, 0.0F);
  }
};

TEST_F(CanBaseCommands, SendsNothingUnlessCommandsAreSwitchedOnAndTheWheelsAreItsOwn) {
  for (const CanBaseConfig& config : {CanBaseConfig{}, CanBaseConfig{.wheels = false, .commands = true}}) {
    start(config);
    driver_->command(1.0, 1.0);
    runFor(1s);
    driver_->stop();
    EXPECT_TRUE(bus_.sent.empty());
  }
}

TEST_F(CanBaseCommands, SendsSpeedsAt50HzWhileTheyAreFresh) {
  start({.wheel = {.sign = {1.0, -1.0}, .gear_ratio = 2.0}, .commands = true});
  runFor(1s);
  EXPECT_NEAR(static_cast<int>(bus_.sent.size()), 2 * 50, 4);
  expectOnlyZeros();
  bus_.sent.clear();
  driver_->command(kTurn, -kTurn / 2.0);
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
  EXPECT_NEAR(driving, 2 * 25, 4) << "half a second";
  EXPECT_NEAR(stopping, 2 * 2975, 4) << "zeros from then on";
}

TEST_F(CanBaseCommands, SendsZeroAtTheEnd) {
  start({.commands = true});
  runFor(100ms);
  driver_->command(1.0, 1.0);
  runFor(100ms);
  driver_->stop();
  bus_.sent.erase(bus_.sent.begin(), bus_.sent.end() - 2);
  expectOnlyZeros();
}

TEST_F(CanBaseCommands, DoesNotSendWhatIsNotANumberAndLimitsTheRest) {
  start({.wheel = {.max_speed = 10.0}, .commands = true});
  driver_->command(std::numeric_limits<double>::quiet_NaN(), 0.0);
  runFor(100ms);
  expectOnlyZeros();
  bus_.sent.clear();
  driver_->command(1000.0, 0.0);
  runFor(100ms);
  ASSERT_FALSE(bus_.sent.empty());
  EXPECT_NEAR(odrive::parseInputVelocity(0x10, bus_.sent[0])->velocity, 10.0 / kTurn, 1e-5);
}

TEST_F(CanBaseCommands, SendsNoOldSpeedsAfterTheQueueWasFull) {
  start({.commands = true});
  runFor(100ms);
  bus_.send_error = ENOBUFS;
  bus_.sent.clear();
  driver_->command(1.0, 1.0);
  runFor(2s);
  bus_.send_error = 0;
  runFor(1s);
  expectOnlyZeros();
  EXPECT_GT(driver_->linkCounters().queue_full, 20U);
}

TEST_F(CanBaseCommands, SendsNoSpeedThatBecameOldWhileItWaitedForRoom) {
  start({.commands = true});
  runFor(100ms);
  driver_->command(1.0, 1.0);
  runFor(480ms);
  bus_.send_error = ENOBUFS;
  runFor(20ms);
  bus_.send_error = 0;
  bus_.sent.clear();
  runFor(100ms);
  expectOnlyZeros();
}

TEST_F(CanBaseCommands, NeverMixesTheSpeedsOfTwoCommands) {
  CanBase driver({.commands = true}, monotonicNow, {}, std::make_unique<test::FakeCanPort>(bus_));
  std::atomic<bool> done{false};
  std::thread commander([&] {
    for (int i = 0; !done; i = (i + 1) % 50) driver.command(i, -i);
  });
  for (const Timestamp end = monotonicNow() + 20s; bus_.sent.size() < 40 && monotonicNow() < end;) driver.tick();
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
}  // namespace slam
