// SPDX-License-Identifier: BSD-3-Clause
// Two VESCs on the bus, from their frames to angles, and whether the wheels stop.
#include "drivers/can/vesc_drive.hpp"

#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>

#include "drivers/can/can_base.hpp"
#include "drivers/can/fake_can_port.hpp"
#include "tools/sim/can/can_emulator.hpp"

namespace slam::vesc_drive_test {
namespace {

using namespace std::chrono_literals;
namespace vesc = can::vesc;

constexpr std::array<int, 2> kIds{10, 200};  // one above those of ODrives
constexpr Duration kTick = 5ms;
constexpr double kTurn = 2.0 * std::numbers::pi;

TEST(VescDrive, MakesTurnsOfTachometerAndElectricTurns) {
  VescDrive drive(10, 7);
  const Timestamp now{10s};
  EXPECT_FALSE(drive.take(now, vesc::encode(11, vesc::Status{})).is_status) << "another's";
  const auto alone = drive.take(now, vesc::encode(10, vesc::Status5{.tachometer = 42}));
  EXPECT_TRUE(alone.is_status);
  EXPECT_FALSE(alone.estimates) << "its speed is not known yet";
  EXPECT_FALSE(drive.take(now, vesc::encode(10, vesc::Status{.erpm = -840})).estimates);
  const auto news = drive.take(now, vesc::encode(10, vesc::Status5{.tachometer = -84}));
  ASSERT_TRUE(news.estimates);
  EXPECT_FLOAT_EQ(news.estimates->position, -2.0F);
  EXPECT_FLOAT_EQ(news.estimates->velocity, -2.0F);
  EXPECT_FALSE(drive.take(now + 1s, vesc::encode(10, vesc::Status5{})).estimates) << "its speed is old";
  EXPECT_EQ(vesc::parseSetRpm(10, drive.encodeSpeed(-2.0)), -840);
  EXPECT_TRUE(vesc::parseSetRpm(10, drive.encodeSpeed(1e12))) << "whatever is asked for";
  EXPECT_FALSE(drive.take(now, vesc::encode(10, vesc::Status4{.transistors = 912})).estimates);
  EXPECT_NEAR(drive.transistors(), 91.2, 1e-9);
}

class Vescs : public testing::Test {
 protected:
  void SetUp() override { start(); }
  void start() {
    CanBaseConfig config{.imu = false,
                         .protocol = can::Protocol::kVesc,
                         .nodes = kIds,
                         .pole_pairs = sim::CanEmulator::kPolePairs,
                         .commands = true,
                         .wheel_radius = 0.1,
                         .half_track = 0.2};
    driver_ = std::make_unique<CanBase>(
        config, test::FakeCanBus::now,
        CanBase::Sinks{.wheels = [this](const WheelAngles& angles) { wheels_.push_back(angles); }, .imu = nullptr},
        std::make_unique<test::FakeCanPort>(bus_));
  }
  /// @param each is called before each tick
  void runFor(
      Duration time, const std::function<void()>& each = [] {}) {
    for (const Timestamp end = bus_.clock + time; bus_.clock < end;) {
      bus_.clock += kTick;
      each();
      driver_->tick();
      for (const can::Frame& frame : bus_.sent) emulator_.receive(frame);
      bus_.sent.clear();
      for (std::size_t side = 0; side < 2; ++side)
        angles_[side] += kTurn * static_cast<double>(emulator_.drive()[side]) * toSeconds(kTick);
      std::vector<can::Frame> out;
      emulator_.step(bus_.clock, {.angles = angles_}, out);
      for (const can::Frame& frame : out) {
        if (frame.extended && !isLost(frame)) bus_.put(frame);
      }
    }
  }
  void driveFor(Duration time, const Twist2& twist) {
    runFor(time, [&] { driver_->command(twist); });
  }
  bool isLost(const can::Frame& frame) const { return lost_ && lost_(frame); }
  bool stands() const { return emulator_.drive() == std::array{0.0F, 0.0F}; }
  bool has(const ProblemKind& kind) { return driver_->wheelStatus().problem().is(kind); }
  std::string words() { return driver_->wheelStatus().problem().words(); }
  DeviceState state() { return driver_->wheelStatus().state; }

  test::FakeCanBus bus_;
  sim::CanEmulator emulator_{1, kIds, can::Protocol::kVesc};
  std::array<double, 2> angles_{3.0, -40.0};  // [rad] of the wheels
  std::function<bool(const can::Frame&)> lost_;
  std::vector<WheelAngles> wheels_;
  std::unique_ptr<CanBase> driver_;
};

TEST_F(Vescs, CountTheWayThatTheyDroveAsTheyAreAskedTo) {
  runFor(1s);
  ASSERT_EQ(state(), DeviceState::kStreaming) << words();
  EXPECT_EQ(words(), "");
  const std::array<double, 2> from = angles_;
  const WheelAngles before = wheels_.back();
  driveFor(4s, {.vx = 0.3, .omega = 0.5});
  driveFor(3s, {.vx = -0.2});
  runFor(1s);
  ASSERT_TRUE(stands());
  EXPECT_EQ(words(), "");
  const double step = kTurn / (6 * sim::CanEmulator::kPolePairs);
  for (std::size_t side = 0; side < 2; ++side)
    EXPECT_NEAR(wheels_.back().angles[side] - before.angles[side], angles_[side] - from[side], 2 * step);
  EXPECT_NEAR(angles_[1] - from[1] - angles_[0] + from[0], 4.0 * 2.0 * 0.2 * 0.5 / 0.1, 0.1);
  EXPECT_NEAR(static_cast<double>(wheels_.size()), 50 * 9, 15) << "50 Hz";
}

TEST_F(Vescs, CreepWithoutBeingTakenForFrozen) {
  runFor(1s);
  driveFor(5s, {.vx = 0.02});  // one step of the tachometer in 0.75 s
  EXPECT_EQ(state(), DeviceState::kStreaming) << words();
  EXPECT_EQ(words(), "");
}

TEST_F(Vescs, GetASpeedAt50HzAllTheTimeAndZeroBehindTheLastCommand) {
  runFor(1s);
  const int before = emulator_.commands();
  runFor(2s);
  EXPECT_NEAR(emulator_.commands() - before, 200, 6) << "both";
  driveFor(1s, {.vx = 0.3});
  EXPECT_FALSE(stands());
  runFor(SpeedCommand::kLasts + 50ms);
  EXPECT_TRUE(stands());
}

TEST_F(Vescs, BothStopWhenOneIsSilentAndDriveByANewCommand) {
  runFor(1s);
  driveFor(1s, {.vx = 0.3});
  ASSERT_FALSE(stands());
  lost_ = [](const can::Frame& frame) { return static_cast<int>(frame.id & 0xFF) == kIds[1]; };
  driveFor(500ms, {.vx = 0.3});
  EXPECT_TRUE(stands());
  driveFor(1s, {.vx = 0.3});
  EXPECT_TRUE(stands());
  EXPECT_TRUE(has(problem::kNoFramesStops)) << words();
  lost_ = nullptr;
  runFor(1s);
  EXPECT_TRUE(stands());
  driveFor(1s, {.vx = 0.3});
  EXPECT_FALSE(stands()) << words();
}

TEST_F(Vescs, BothStopWhenOneDoesNotFollow) {
  runFor(1s);
  driveFor(1s, {.vx = 0.3});
  emulator_.inject("deaf", 1.0);
  driveFor(1s, {.vx = 0.3});
  EXPECT_TRUE(stands());
  EXPECT_TRUE(has(problem::kVescNotFollowing)) << words();
  EXPECT_EQ(state(), DeviceState::kFault);
}

TEST_F(Vescs, StopAtTheEndAndByThemselvesWhereNothingComes) {
  runFor(1s);
  driveFor(1s, {.vx = 0.3});
  driver_->stop();
  for (const can::Frame& frame : bus_.sent) emulator_.receive(frame);
  EXPECT_TRUE(stands());
  bus_.sent.clear();
  start();
  driveFor(2s, {.vx = 0.3});
  ASSERT_FALSE(stands());
  std::vector<can::Frame> out;
  for (int i = 0; i < 210; ++i) emulator_.step(bus_.clock += kTick, {.angles = angles_}, out);
  EXPECT_TRUE(stands()) << "its own time-out";
}

TEST_F(Vescs, AreNamedWithWhatIsToBeSet) {
  lost_ = [](const can::Frame& frame) { return frame.id >> 8 == static_cast<unsigned>(vesc::Packet::kStatus5); };
  runFor(2s);
  EXPECT_TRUE(has(problem::kVescNoEstimates)) << words();
  lost_ = nullptr;
  runFor(2s);
  EXPECT_EQ(words(), "");
  emulator_.inject("slow", 6.0);
  runFor(4s);
  EXPECT_TRUE(has(problem::kVescSlow)) << words();
  emulator_.inject("slow", 1.0);
  emulator_.inject("silent", 1.0);
  runFor(2s);
  EXPECT_TRUE(has(problem::kNoWheels)) << words();
}

TEST_F(Vescs, CountDamageAndNeverJump) {
  runFor(1s);
  for (int i = 0; i < 20; ++i) {
    emulator_.inject("garbage", 1.0);
    runFor(100ms);
    emulator_.inject("garbage", 0.0);
    driveFor(400ms, {.vx = 0.2});
  }
  EXPECT_GT(driver_->wheelStatus().rejects, 20);
  for (std::size_t i = 1; i < wheels_.size(); ++i) {
    if (wheels_[i].restarted) continue;
    EXPECT_LT(std::abs(wheels_[i].angles[0] - wheels_[i - 1].angles[0]), 3.0) << i;
  }
}

}  // namespace
}  // namespace slam::vesc_drive_test
