// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/can/can_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <numbers>
#include <string>

#include "drivers/can/can_base.hpp"
#include "drivers/can/fake_can_port.hpp"

namespace slam::sim::can_emulator_test {
namespace {

using namespace std::chrono_literals;
namespace odrive = can::odrive;
namespace xsens = can::xsens;

constexpr double kTurn = 2.0 * std::numbers::pi;

/// Wheels that turn at 1 and -2 turns a second.
class CanEmulatorTest : public testing::Test {
 protected:
  std::vector<can::Frame> runFor(Duration time) {
    std::vector<can::Frame> out;
    for (const Timestamp end = clock_ + time; clock_ < end;) {
      clock_ += 5ms;
      const double t = toSeconds(clock_ - kStart);
      emulator_.step(clock_, {.angles = {kTurn * t, -2.0 * kTurn * t}, .gyro = {0, 0, 0.5F}, .accel = {0, 0, 9.75F}},
                     out);
    }
    return out;
  }
  /// The last of an id.
  static can::Frame last(const std::vector<can::Frame>& frames, std::uint32_t id) {
    const auto at = std::find_if(frames.rbegin(), frames.rend(), [id](const auto& frame) { return frame.id == id; });
    return at == frames.rend() ? can::Frame{} : *at;
  }
  static odrive::EncoderEstimates left(const std::vector<can::Frame>& frames) {
    return odrive::parseEncoderEstimates(0x10, last(frames, 0x209)).value_or(odrive::EncoderEstimates{});
  }

  static constexpr Timestamp kStart{100s};
  Timestamp clock_ = kStart;
  CanEmulator emulator_;
};

TEST_F(CanEmulatorTest, SendsEachIdAtItsRate) {
  std::map<std::uint32_t, int> counts;
  for (const can::Frame& frame : runFor(10s)) ++counts[frame.id];
  const std::map<std::uint32_t, int> expected = {{0x201, 100},  {0x301, 100},  {0x209, 1000}, {0x309, 1000},
                                                 {0x005, 1000}, {0x021, 1000}, {0x032, 1000}, {0x034, 1000}};
  EXPECT_EQ(counts, expected);
}

TEST_F(CanEmulatorTest, SendsTheTruth) {
  const auto frames = runFor(1s);
  const double t = toSeconds(clock_ - 5ms - kStart);  // the last estimates were sent one step ago
  EXPECT_NEAR(left(frames).position, t, 1e-5);
  EXPECT_NEAR(left(frames).velocity, 1.0, 1e-4);
  EXPECT_NEAR(odrive::parseEncoderEstimates(0x18, last(frames, 0x309))->position, -2.0 * t, 1e-5);
  EXPECT_EQ(odrive::parseHeartbeat(0x10, last(frames, 0x201))->state, 8);
  EXPECT_THAT(xsens::parseSampleTime(last(frames, 0x005)), testing::Optional(9900U));
  EXPECT_THAT(xsens::parseRateOfTurn(last(frames, 0x032)), testing::Optional(xsens::Vector3{0, 0, 0.5F}));
  EXPECT_THAT(xsens::parseAcceleration(last(frames, 0x034)), testing::Optional(xsens::Vector3{0, 0, 9.75F}));
}

TEST_F(CanEmulatorTest, SendsFirmware06AndItsVersion) {
  emulator_.receive(odrive::requestVersion(0x10));
  EXPECT_EQ(last(runFor(100ms), 0x200).size, 0) << "0.5 does not know the question";
  ASSERT_TRUE(emulator_.inject("firmware", 0.6));
  const std::array<std::uint8_t, 8> closed_loop = {0, 0, 0, 0, 8, 1, 1, 0};
  EXPECT_EQ(last(runFor(200ms), 0x201).data, closed_loop);
  emulator_.receive(odrive::requestVersion(0x18));
  const auto version = odrive::parseVersion(0x18, last(runFor(100ms), 0x300));
  ASSERT_TRUE(version);
  EXPECT_EQ(version->dialect(), odrive::Dialect::k06);
  ASSERT_TRUE(emulator_.inject("watchdog", 0.5));
  runFor(1s);
  const auto heartbeat = odrive::parseHeartbeat(0x10, last(runFor(200ms), 0x201), odrive::Dialect::k06);
  EXPECT_EQ(heartbeat,
            (odrive::Heartbeat{.axis_error = 0x01000000, .state = 1, .trajectory_done = true, .procedure_result = 3}));
  EXPECT_FALSE(emulator_.inject("firmware", 0.7));
}

TEST_F(CanEmulatorTest, SendsEstimatesAndPartsOfTheImuAtOtherRates) {
  const auto countOf = [](const std::vector<can::Frame>& frames, std::uint32_t id) {
    return std::count_if(frames.begin(), frames.end(), [id](const auto& frame) { return frame.id == id; });
  };
  ASSERT_TRUE(emulator_.inject("estimates", 200.0));
  ASSERT_TRUE(emulator_.inject("imu_time", 0.0));
  ASSERT_TRUE(emulator_.inject("imu_acceleration", 4.0));
  ASSERT_TRUE(emulator_.inject("quaternion", 0.0));
  const auto frames = runFor(10s);
  EXPECT_NEAR(static_cast<double>(countOf(frames, 0x209)), 50.0, 1.0);
  EXPECT_EQ(countOf(frames, 0x005), 0);
  EXPECT_EQ(countOf(frames, 0x021), 0);
  EXPECT_EQ(countOf(frames, 0x032), 1000);
  EXPECT_EQ(countOf(frames, 0x034), 250);
  EXPECT_FALSE(emulator_.inject("imu_time", -1.0));
}

TEST(CanEmulatorNodes, AreThoseThatItIsGiven) {
  CanEmulator emulator(1, {0, 1});
  std::vector<can::Frame> frames;
  for (Timestamp now{1s}; now < Timestamp{2s}; now += 5ms) emulator.step(now, {}, frames);
  EXPECT_TRUE(std::any_of(frames.begin(), frames.end(), [](const auto& frame) { return frame.id == 0x001; }));
  EXPECT_TRUE(std::any_of(frames.begin(), frames.end(), [](const auto& frame) { return frame.id == 0x029; }));
}

TEST_F(CanEmulatorTest, TakesCommands) {
  emulator_.receive(odrive::encodeInputVelocity(0x10, {1.5F, 0.0F}));
  emulator_.receive(odrive::encodeInputVelocity(0x18, {-0.5F, 0.0F}));
  EXPECT_THAT(emulator_.asked(), testing::ElementsAre(1.5F, -0.5F));
  EXPECT_EQ(emulator_.commands(), 2);
  emulator_.receive(odrive::encodeAxisState(0x10, odrive::AxisState::kIdle));
  EXPECT_EQ(odrive::parseHeartbeat(0x10, last(runFor(200ms), 0x201))->state, 1);
}

TEST_F(CanEmulatorTest, TurnsTheWheelsForEverAtTheLastSpeedWhileItIsArmed) {
  emulator_.receive(odrive::encodeInputVelocity(0x10, {1.5F, 0.0F}));
  runFor(60s);
  EXPECT_THAT(emulator_.drive(), testing::ElementsAre(1.5F, 0.0F));
  emulator_.receive(odrive::encodeAxisState(0x10, odrive::AxisState::kIdle));
  EXPECT_THAT(emulator_.drive(), testing::ElementsAre(0.0F, 0.0F));
  emulator_.receive(odrive::encodeAxisState(0x10, odrive::AxisState::kClosedLoop));
  EXPECT_THAT(emulator_.drive(), testing::ElementsAre(1.5F, 0.0F)) << "it still holds it";
}

TEST_F(CanEmulatorTest, DisarmsADriveWhoseWatchdogIsNotFed) {
  ASSERT_TRUE(emulator_.inject("watchdog", 0.5));
  emulator_.receive(odrive::encodeInputVelocity(0x10, {1.5F, 0.0F}));
  emulator_.receive(odrive::encodeInputVelocity(0x18, {1.0F, 0.0F}));
  for (int i = 0; i < 10; ++i) {
    runFor(100ms);
    emulator_.receive(odrive::encodeInputVelocity(0x18, {1.0F, 0.0F}));
  }
  EXPECT_THAT(emulator_.drive(), testing::ElementsAre(0.0F, 1.0F));
  EXPECT_EQ(odrive::parseHeartbeat(0x10, last(runFor(200ms), 0x201)),
            (odrive::Heartbeat{.axis_error = 0x800, .state = 1, .trajectory_done = true}));
  EXPECT_FALSE(emulator_.armed());
}

TEST_F(CanEmulatorTest, CannotArmADriveWithAnErrorWhichAnIdleOneHasToo) {
  emulator_.receive(odrive::encodeAxisState(0x10, odrive::AxisState::kIdle));
  ASSERT_TRUE(emulator_.inject("watchdog", 0.5));
  for (int i = 0; i < 10; ++i) {
    runFor(100ms);
    emulator_.receive(odrive::encodeInputVelocity(0x18, {}));
  }
  emulator_.receive(odrive::encodeAxisState(0x10, odrive::AxisState::kClosedLoop));
  EXPECT_FALSE(emulator_.armed());
  emulator_.receive(odrive::encodeClearErrors(0x10));
  emulator_.receive(odrive::encodeAxisState(0x10, odrive::AxisState::kClosedLoop));
  EXPECT_TRUE(emulator_.armed());
}

TEST_F(CanEmulatorTest, FallsSilentAndSendsAgain) {
  runFor(1s);
  ASSERT_TRUE(emulator_.inject("silent", 1));
  EXPECT_TRUE(runFor(1s).empty());
  emulator_.inject("silent", 0);
  EXPECT_GT(runFor(1s).size(), 600U);
}

TEST_F(CanEmulatorTest, SendsGarbageOfAnySize) {
  ASSERT_TRUE(emulator_.inject("garbage", 1));
  const auto frames = runFor(1s);
  const auto odd =
      std::count_if(frames.begin(), frames.end(), [](const auto& f) { return f.id == 0x209 && f.size != 8; });
  EXPECT_GT(odd, 20);
  emulator_.inject("garbage", 0);
  EXPECT_NEAR(left(runFor(1s)).velocity, 1.0, 1e-3);
}

TEST_F(CanEmulatorTest, IsStuckAndWrong) {
  const auto before = left(runFor(1s));
  ASSERT_TRUE(emulator_.inject("stuck", 1));
  EXPECT_NEAR(left(runFor(1s)).position, before.position, 0.02);
  emulator_.inject("stuck", 0);
  ASSERT_TRUE(emulator_.inject("wrong", 3.0));
  const auto wrong = left(runFor(1s));
  EXPECT_NEAR(wrong.position, 3.0 * toSeconds(clock_ - 5ms - kStart), 1e-3);
}

TEST_F(CanEmulatorTest, DelaysAllFrames) {
  ASSERT_TRUE(emulator_.inject("delay", 100));
  EXPECT_TRUE(runFor(100ms).empty());
  const auto late = left(runFor(1s));
  EXPECT_NEAR(late.position, toSeconds(clock_ - 105ms - kStart), 1e-3);
}

TEST_F(CanEmulatorTest, ReportsAnAxisError) {
  ASSERT_TRUE(emulator_.inject("axis_error", 0x800));
  const auto heartbeat = odrive::parseHeartbeat(0x10, last(runFor(200ms), 0x201));
  EXPECT_EQ(heartbeat, (odrive::Heartbeat{.axis_error = 0x800, .state = 1, .trajectory_done = true}));
  emulator_.inject("axis_error", 0);
  EXPECT_EQ(odrive::parseHeartbeat(0x10, last(runFor(200ms), 0x201)),
            (odrive::Heartbeat{.state = 8, .trajectory_done = true}));
}

TEST_F(CanEmulatorTest, HasALeftDriveThatIsIdleWithoutAnErrorOrLeavesSpeedsOut) {
  const auto ask = [&] {
    for (const int node : {0x10, 0x18}) emulator_.receive(odrive::encodeInputVelocity(node, {1.0F, 0.0F}));
    return emulator_.drive();
  };
  ASSERT_TRUE(emulator_.inject("idle", 1));
  EXPECT_EQ(ask(), (std::array<float, 2>{0.0F, 1.0F}));
  EXPECT_EQ(odrive::parseHeartbeat(0x10, last(runFor(200ms), 0x201))->axis_error, 0U);
  emulator_.inject("idle", 0);
  EXPECT_EQ(ask(), (std::array<float, 2>{1.0F, 1.0F}));
  ASSERT_TRUE(emulator_.inject("deaf", 1));
  EXPECT_EQ(ask(), (std::array<float, 2>{0.0F, 1.0F}));
  EXPECT_TRUE(emulator_.armed());
}

TEST_F(CanEmulatorTest, DistinguishesWhetherItsWatchdogIsOnFromFirmware06On) {
  const auto answer = [&] {
    emulator_.receive(odrive::requestParameter(0x10, CanEmulator::kWatchdogEndpoint));
    return odrive::parseParameter(0x10, last(runFor(100ms), 0x205));
  };
  EXPECT_FALSE(answer());
  emulator_.inject("firmware", 0.6);
  EXPECT_EQ(answer(), (odrive::Parameter{CanEmulator::kWatchdogEndpoint, 0}));
  emulator_.inject("watchdog", 5.0);
  EXPECT_EQ(answer(), (odrive::Parameter{CanEmulator::kWatchdogEndpoint, 1}));
}

TEST_F(CanEmulatorTest, GoesBusOffAndIsRestarted) {
  ASSERT_TRUE(emulator_.inject("bus_off", 1));
  EXPECT_THAT(runFor(1s), testing::ElementsAre(can::Frame{.id = 0x40, .size = 8, .error = true}));
  emulator_.inject("bus_off", 0);
  const auto frames = runFor(1s);
  ASSERT_FALSE(frames.empty());
  EXPECT_EQ(frames.front(), (can::Frame{.id = 0x100, .size = 8, .error = true}));
  EXPECT_GT(frames.size(), 600U);
}

TEST_F(CanEmulatorTest, RefusesOtherKindsAndValuesBeyondReason) {
  EXPECT_FALSE(emulator_.inject("sulk", 1));
  for (const char* kind : {"silent", "garbage", "stuck", "wrong", "slow", "delay", "watchdog", "axis_error", "idle",
                           "deaf", "firmware", "estimates", "imu_time", "imu_acceleration", "quaternion", "bus_off"}) {
    for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
      EXPECT_FALSE(emulator_.inject(kind, value)) << kind << " " << value;
    EXPECT_EQ(emulator_.inject(kind, 1e300), kind == std::string("wrong")) << kind;
  }
}

// ---- What the driver makes of it

/// The emulator on one end of a fake bus, the driver on the other, in virtual time.
class CanFaults : public testing::Test {
 protected:
  void runFor(Duration time) {
    runUntil([] { return false; }, time);
  }
  /// @return [s] the limit when the condition never held
  template <typename Condition>
  double runUntil(Condition&& condition, Duration limit) {
    const Timestamp begin = bus_.clock;
    while (bus_.clock - begin < limit) {
      bus_.clock += 5ms;
      const double t = toSeconds(bus_.clock - test::FakeCanBus::kStart);
      const auto noise = static_cast<float>(0.05 * std::sin(1e3 * t));
      std::vector<can::Frame> frames;
      emulator_.step(bus_.clock, {.angles = {5.0 * t, 4.0 * t}, .gyro = {0, noise, 0.2F}, .accel = {0, 0, 9.75F}},
                     frames);
      for (const can::Frame& frame : frames) bus_.put(frame);
      driver_.tick();
      if (condition()) return toSeconds(bus_.clock - begin);
    }
    return toSeconds(limit);
  }
  bool streaming() {
    return driver_.wheelStatus().state == DeviceState::kStreaming &&
           driver_.imuStatus().state == DeviceState::kStreaming && wheelReason().empty();
  }
  std::string wheelReason() { return driver_.wheelStatus().problem().words(); }
  std::string imuReason() { return driver_.imuStatus().problem().words(); }
  /// Injects, expects it to be noticed, takes it back, and expects the devices to be used again.
  void expectNoticed(const std::string& kind, double value, double back, double within = 1.0) {
    emulator_.inject(kind, value);
    EXPECT_LT(runUntil([&] { return !streaming(); }, 5s), within) << kind;
    runFor(2s);
    seen_ = wheelReason() + "; " + imuReason();
    emulator_.inject(kind, back);
    EXPECT_LT(runUntil([&] { return streaming(); }, 5s), 1.0) << kind << ": " << wheelReason() << "; " << imuReason();
    runFor(1s);
  }

  test::FakeCanBus bus_;
  CanEmulator emulator_;
  int wheels_ = 0;
  CanBase driver_{{},
                  test::FakeCanBus::now,
                  {.wheels = [this](const WheelAngles&) { ++wheels_; }, .imu = [](const ImuSample&) {}},
                  std::make_unique<test::FakeCanPort>(bus_)};
  std::string seen_;
};

TEST_F(CanFaults, AreNoticedWithinASecondInWordsAndForgottenWithTheCause) {
  runFor(1s);
  ASSERT_TRUE(streaming());
  expectNoticed("silent", 1, 0);
  EXPECT_THAT(seen_, testing::AllOf(testing::HasSubstr("no frames of the left wheel"),
                                    testing::HasSubstr("no frames of the IMU")));
  expectNoticed("stuck", 1, 0);
  EXPECT_THAT(seen_, testing::AllOf(testing::HasSubstr("its position never changes"),
                                    testing::HasSubstr("its values never change")));
  expectNoticed("axis_error", 0x800, 0);
  EXPECT_THAT(seen_, testing::HasSubstr("left wheel: axis error 0x800, disarmed"));
  expectNoticed("bus_off", 1, 0);
  EXPECT_THAT(seen_, testing::HasSubstr("bus-off"));
}

TEST_F(CanFaults, GarbageIsCountedAndLeavesNoTrace) {
  runFor(1s);
  emulator_.inject("garbage", 1);
  runFor(10s);
  EXPECT_GT(driver_.wheelStatus().rejects.load(), 500);
  EXPECT_GT(driver_.imuStatus().rejects.load(), 500);
  emulator_.inject("garbage", 0);
  runFor(2s);
  EXPECT_TRUE(streaming()) << wheelReason() << "; " << imuReason();
  const int before = wheels_;
  runFor(1s);
  EXPECT_NEAR(wheels_ - before, 100, 2);
}

}  // namespace
}  // namespace slam::sim::can_emulator_test
