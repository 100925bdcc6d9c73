// SPDX-License-Identifier: BSD-3-Clause
// Each base of the table at its emulator. No motor moves without a command, and each stops.
#include "drivers/base/serial_base.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "drivers/base/base_rig.hpp"
#include "firmware_if/slamd_base/base_frame.hpp"

namespace slam::serial_base_test {
namespace {

using namespace std::chrono_literals;
using test::BaseRig;
using test::virtual_now;

std::vector<const char*> words() {
  std::vector<const char*> words;
  for (const BaseFacts& facts : baseTable()) words.push_back(facts.driver);
  return words;
}

class EachBase : public testing::TestWithParam<const char*> {
 protected:
  const char* word() const { return GetParam(); }
  bool isPolled() const {
    constexpr std::array<std::string_view, 4> kPolled{"text", "roboclaw", "opencr", "vesc"};
    return std::find(kPolled.begin(), kPolled.end(), word()) != kPolled.end();
  }
  /// A base whose own watchdog stops it may stand before slamd has stopped it.
  bool keepsItsSpeed() const { return findBase(word())->stops_after == 0.0; }
};

/// Way along x that the wheels tell [m].
double wayOf(const BaseRig& rig, std::size_t from) {
  const auto& a = rig.wheels[from].angles;
  const auto& b = rig.wheels.back().angles;
  return 0.5 * (b[0] - a[0] + b[1] - a[1]) * rig.geometry.base.wheel_radius;
}
/// Turn that they tell [rad].
double turnedBy(const BaseRig& rig, std::size_t from) {
  const auto& a = rig.wheels[from].angles;
  const auto& b = rig.wheels.back().angles;
  return 0.5 * (b[1] - a[1] - b[0] + a[0]) * rig.geometry.base.wheel_radius / rig.geometry.base.half_track;
}

TEST_P(EachBase, CountsTheWayThatItDroveThoughItsCountersWrap) {
  BaseRig rig(word());
  ASSERT_TRUE(rig.connect()) << rig.words();
  const std::size_t begin = rig.wheels.size() - 1;
  const Pose2 from = rig.robot.pose();
  rig.driveFor(6s, {.vx = 0.25});
  rig.driveFor(9s, {.vx = -0.2, .omega = 0.5});
  rig.driveFor(6s, {.omega = -1.0});
  rig.runFor(1s);
  ASSERT_TRUE(rig.stands());
  for (std::size_t i = begin; i < rig.wheels.size(); ++i) {
    EXPECT_FALSE(rig.wheels[i].restarted && i > begin) << i;
    ASSERT_TRUE(i == 0 || rig.wheels[i].stamp >= rig.wheels[i - 1].stamp);
  }
  const double last = 6 + toSeconds(SpeedCommand::kLasts);  // [s]
  const double way = 6 * 0.25 - 9 * 0.2, turn = 9 * 0.5 - last * 1.0;
  EXPECT_NEAR(wayOf(rig, begin), way, 0.15) << "slip and wheels of 1 %";
  EXPECT_NEAR(turnedBy(rig, begin), turn, 0.5);
  EXPECT_NEAR(wrapAngle(rig.robot.pose().theta - from.theta), wrapAngle(turn), 0.35) << "it drives as it is told";
}

TEST_P(EachBase, ReadsAtTheRateThatIsPromised) {
  BaseRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.runFor(2s);
  const std::size_t before = rig.wheels.size();
  rig.driveFor(10s, {.vx = 0.1});
  EXPECT_NEAR(static_cast<double>(rig.wheels.size() - before), 10 * rig.facts.rate, 0.15 * 10 * rig.facts.rate);
}

TEST_P(EachBase, NeverMovesWithoutACommand) {
  for (const bool may_drive : {false, true}) {
    BaseRig rig(word());
    rig.start(may_drive);
    ASSERT_TRUE(rig.connect());
    rig.runFor(10s);
    EXPECT_TRUE(rig.stands());
    EXPECT_EQ(rig.robot.pose().x, 0.0);
    EXPECT_EQ(rig.robot.pose().theta, 0.0);
    EXPECT_EQ(rig.base->command({.vx = 0.2}, virtual_now), may_drive);
    if (may_drive) continue;
    rig.runFor(1s);
    EXPECT_EQ(rig.robot.pose().x, 0.0);
  }
}

TEST_P(EachBase, StopsBehindTheLastCommand) {
  BaseRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.driveFor(2s, {.vx = 0.3, .omega = 0.4});
  ASSERT_FALSE(rig.stands());
  EXPECT_LE(rig.timeToStop(), SpeedCommand::kLasts + 100ms);
  rig.runFor(2s);
  const std::size_t written = rig.written.size();
  rig.runFor(3s);
  EXPECT_TRUE(rig.stands());
  const bool is_asked = isPolled();
  EXPECT_TRUE(is_asked || rig.written.size() == written) << "the base is known to stand: nothing is owed any more";
}

TEST_P(EachBase, RefusesWhatIsNoNumberAndLimitsWhatIsTooFast) {
  BaseRig rig(word());
  rig.start(true, {.max_speed = 0.2, .max_turn_rate = 0.5});
  ASSERT_TRUE(rig.connect());
  EXPECT_FALSE(rig.base->command({.vx = std::numeric_limits<double>::quiet_NaN()}, virtual_now));
  EXPECT_FALSE(rig.base->command({.omega = std::numeric_limits<double>::infinity()}, virtual_now));
  rig.runFor(500ms);
  EXPECT_TRUE(rig.stands());
  rig.driveFor(1s, {.vx = 40.0});
  EXPECT_NEAR(rig.emulator->drive().vx, 0.2, 0.01);
  EXPECT_GT(rig.base->limitedSpeeds(), 0U);
  rig.driveFor(1s, {.omega = -70.0});
  EXPECT_NEAR(rig.emulator->drive().omega, -0.5, 0.05);
}

TEST_P(EachBase, IsNoFasterThanItsWheelsCanAndKeepsTheCurve) {
  BaseRig rig(word());
  rig.start(true, {.max_speed = 5.0, .max_turn_rate = 5.0});
  if (!(rig.facts.fastest > 0.0)) GTEST_SKIP() << "it has no such limit";
  ASSERT_TRUE(rig.connect());
  rig.driveFor(1s, {.vx = 3.0, .omega = 3.0});
  const Twist2 twist = rig.emulator->drive();
  EXPECT_NEAR(twist.vx + rig.geometry.base.half_track * twist.omega, rig.facts.fastest, 0.01);
  EXPECT_NEAR(twist.vx / twist.omega, 1.0, 0.03);
}

TEST_P(EachBase, IsStoppedByTheSlamdThatFollowsOneThatWasKilled) {
  BaseRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.driveFor(1s, {.vx = 0.3});
  rig.kill();
  // The reference firmware has stopped by itself while this one waited for an acknowledgement.
  EXPECT_EQ(rig.stands(), std::string_view(word()) == "frame");
  rig.start();
  EXPECT_LE(rig.timeToStop(), 100ms);
}

TEST_P(EachBase, IsStoppedAtTheEnd) {
  BaseRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.driveFor(1s, {.vx = 0.3});
  ASSERT_FALSE(rig.stands());
  rig.base->stop();
  EXPECT_TRUE(rig.stands());
}

TEST_P(EachBase, GetsItsZeroAgainUntilItIsKnownToHaveIt) {
  BaseRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.driveFor(1s, {.vx = 0.3});
  rig.emulator->inject("deaf", 1.0);
  rig.runFor(1500ms);
  rig.emulator->inject("deaf", 0.0);
  if (keepsItsSpeed()) {
    EXPECT_FALSE(rig.stands());
    EXPECT_LE(rig.timeToStop(), 100ms);
  }
  rig.runFor(1s);
  EXPECT_TRUE(rig.stands());
}

TEST_P(EachBase, IsStoppedThoughNothingOfItIsReceived) {
  BaseRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.driveFor(1s, {.vx = 0.3});
  rig.delay = 60s;  // the line to the computer is cut
  EXPECT_LE(rig.timeToStop(), SpeedCommand::kLasts + 150ms);
}

TEST_P(EachBase, IsStoppedWhenItsPlugIsBack) {
  BaseRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.driveFor(1s, {.vx = 0.3});
  rig.line.unplug();
  rig.runFor(100ms);
  EXPECT_EQ(rig.state(), DeviceState::kAbsent);
  EXPECT_TRUE(rig.has(problem::kPortGone) || rig.has(problem::kPortMissing)) << rig.words();
  rig.runFor(300ms);
  rig.line.plug();
  EXPECT_LE(rig.timeToStop(), 1200ms);
  ASSERT_TRUE(rig.connect());
  rig.runFor(100ms);
  EXPECT_FALSE(rig.wheels.back().restarted);
}

TEST_P(EachBase, NamesSilenceAndNoiseAndGoesOnBehindThem) {
  BaseRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.emulator->inject("silent", 1.0);
  rig.runFor(1s);
  EXPECT_EQ(rig.state(), DeviceState::kStale);
  EXPECT_TRUE(rig.has(problem::kBoardSilent)) << rig.words();
  rig.emulator->inject("silent", 0.0);
  ASSERT_TRUE(rig.connect());
  rig.noise = true;
  rig.runFor(1s);
  EXPECT_EQ(rig.state(), DeviceState::kStale);
  ASSERT_TRUE(rig.runUntil([&] { return rig.state() == DeviceState::kFault; })) << rig.words();
  EXPECT_TRUE(rig.has(problem::kBaseUndecoded) || rig.has(problem::kBoardUnanswered)) << rig.words();
  rig.noise = false;
  ASSERT_TRUE(rig.connect()) << rig.words();
}

TEST_P(EachBase, CountsDamageAndNeverJumps) {
  BaseRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.runFor(1s);
  for (const char* kind : {"lose", "insert", "flip", "checksum"}) {
    for (int i = 0; i < 40; ++i) {
      rig.emulator->inject(kind, 2.0);
      rig.driveFor(150ms, {.vx = 0.2});
    }
  }
  EXPECT_GT(rig.base->wheelStatus().rejects, 20);
  std::size_t jumps = 0;
  for (std::size_t i = 1; i < rig.wheels.size(); ++i) {
    if (rig.wheels[i].restarted) continue;
    jumps += std::abs(rig.wheels[i].angles[0] - rig.wheels[i - 1].angles[0]) > 3.0 ? 1 : 0;
  }
  // A text without a checksum cannot tell a damaged digit from another count.
  EXPECT_TRUE(std::string_view(word()) == "text" || jumps == 0) << jumps;
  ASSERT_TRUE(rig.connect()) << rig.words();
}

TEST_P(EachBase, BeginsAnewWhenItsCountersDo) {
  BaseRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.driveFor(5s, {.vx = 0.3});
  const double before = rig.wheels.back().angles[0];
  rig.emulator->inject("reset", 1.0);
  const std::size_t at = rig.wheels.size();
  ASSERT_TRUE(rig.runUntil([&] { return rig.wheels.size() > at + 5; })) << rig.words();
  EXPECT_NEAR(rig.wheels.back().angles[0], before, 3.0) << "no jump, whatever it counts";
  rig.runFor(1s);
  EXPECT_TRUE(rig.stands());
}

TEST_P(EachBase, IsNamedAtAWrongBaudRate) {
  if (std::string_view(word()) == "create") GTEST_SKIP() << "it is silent, and takes a question for pressed buttons";
  const int right = findBase(word())->baud, wrong = right == 115200 ? 57600 : 115200;
  BaseRig rig(word(), word(), wrong);
  ASSERT_TRUE(rig.runUntil([&] { return rig.has(problem::kOtherBaud); }, 30s)) << rig.words();
  EXPECT_THAT(rig.words(), testing::HasSubstr("set base.baud = " + std::to_string(right)));
}

TEST_P(EachBase, IsNamedWhereAnotherIsExpected) {
  const std::string other = std::string_view(word()) == "kobuki" ? "text" : "kobuki";
  BaseRig rig(word(), other);
  if (std::string_view(word()) == "create") {
    // It sends only when it is asked: a session before has left it streaming.
    BaseRig::Bytes out;
    rig.emulator->exchange(BaseRig::Bytes{128, 148, 8, 7, 22, 34, 35, 41, 42, 43, 44}, virtual_now, out);
  }
  ASSERT_TRUE(rig.runUntil([&] { return rig.has(problem::kForeignBase); }, 30s)) << rig.words();
  EXPECT_THAT(rig.words(), testing::HasSubstr(std::string("set base.driver = \"") + word() + "\""));
}

TEST_P(EachBase, ThatIsLiftedIsReportedAndItsWheelsAreNoMotion) {
  BaseRig rig(word());
  if (isPolled()) GTEST_SKIP() << "it has no such sensor";
  ASSERT_TRUE(rig.connect());
  rig.driveFor(2s, {.vx = 0.3});
  rig.emulator->inject("lifted", 1.0);
  rig.driveFor(200ms, {.vx = 0.3});
  const double at = rig.wheels.back().angles[0];
  const std::size_t written = rig.written.size();
  rig.driveFor(1s, {.vx = 0.3});
  EXPECT_EQ(rig.written.size(), written) << "no speed is sent to wheels in the air";
  EXPECT_TRUE(rig.has(problem::kBaseLifted)) << rig.words();
  EXPECT_EQ(rig.state(), DeviceState::kStreaming);
  EXPECT_TRUE(rig.wheels.back().lifted);
  EXPECT_EQ(rig.wheels.back().angles[0], at);
  EXPECT_TRUE(rig.stands());
  rig.emulator->inject("lifted", 0.0);
  const Timestamp down = virtual_now;
  rig.base->command({.vx = 0.3}, virtual_now);
  rig.runFor(400ms);
  EXPECT_TRUE(rig.has(problem::kBaseLifted)) << "hands may still be at it";
  EXPECT_TRUE(rig.stands());
  rig.runFor(2s);
  EXPECT_TRUE(rig.stands()) << "what was given before it stood is void";
  EXPECT_FALSE(rig.has(problem::kBaseLifted));
  rig.driveFor(500ms, {.vx = 0.3});
  EXPECT_FALSE(rig.stands()) << "a fresh command drives it, " << toSeconds(virtual_now - down);
  EXPECT_FALSE(rig.base->wheelStatus().problem()) << rig.words();
  EXPECT_GT(rig.wheels.back().angles[0], at);
}

TEST_P(EachBase, ReportsABumperAndDrivesOn) {
  BaseRig rig(word());
  const std::string_view base(word());
  if (isPolled() && base != "opencr") GTEST_SKIP() << "it has no such sensor";
  ASSERT_TRUE(rig.connect());
  rig.driveFor(1s, {.vx = 0.3});
  EXPECT_FALSE(rig.base->wheelStatus().problem()) << rig.words();
  rig.emulator->inject("bumped", 1.0);
  rig.driveFor(300ms, {.vx = -0.2});
  EXPECT_TRUE(rig.has(problem::kBaseBumped)) << rig.words();
  EXPECT_EQ(rig.state(), DeviceState::kStreaming);
  EXPECT_FALSE(rig.wheels.back().lifted);
  EXPECT_LT(rig.emulator->drive().vx, -0.1) << "it may drive back";
  rig.emulator->inject("bumped", 0.0);
  rig.runFor(300ms);
  EXPECT_FALSE(rig.has(problem::kBaseBumped));
}

INSTANTIATE_TEST_SUITE_P(, EachBase, testing::ValuesIn(words()),
                         [](const auto& test) { return std::string(test.param); });

TEST(SerialBase, ComparesTheGeometryWithItsMakers) {
  BaseRig rig("kobuki");
  EXPECT_FALSE(rig.base->finding());
  rig.geometry.base.half_track = 0.16;
  rig.start();
  EXPECT_TRUE(rig.base->finding().is(problem::kBaseGeometry));
  EXPECT_THAT(rig.base->finding().words(), testing::HasSubstr("half_track = 0.1150"));
}

TEST(SerialBase, HandsOnTheTurnRateOfAKobukisGyro) {
  BaseRig rig("kobuki");
  ASSERT_TRUE(rig.connect());
  rig.driveFor(2s, {.omega = 0.8});
  ASSERT_GT(rig.imu.size(), 50U);
  EXPECT_NEAR(rig.imu.back().gyro.z(), 0.8, 0.05) << "bias and noise";
  EXPECT_EQ(rig.imu.back().accel.norm(), 0.0) << "not measured";
  EXPECT_NEAR(rig.base->battery(), 16.0F, 0.01F);
}

TEST(SerialBase, HandsOnTheTurnRateOfTheReferenceFirmwareAndNamesAGyroThatIsGone) {
  BaseRig rig("frame");
  ASSERT_TRUE(rig.connect());
  rig.driveFor(2s, {.omega = 0.8});
  ASSERT_GT(rig.imu.size(), 150U);
  EXPECT_NEAR(rig.imu.back().gyro.z(), 0.8, 0.05) << "bias and noise";
  EXPECT_NEAR(rig.base->battery(), 12.1F, 0.01F);
  rig.emulator->inject("gyro", 1.0);
  rig.runFor(1s);
  EXPECT_TRUE(rig.base->imuStatus().problem().is(problem::kBaseNoGyro)) << rig.base->imuStatus().problem().words();
  EXPECT_EQ(rig.state(), DeviceState::kStreaming) << "its wheels are used on";
  rig.emulator->inject("gyro", 0.0);
  rig.runFor(100ms);
  EXPECT_EQ(rig.base->imuStatus().state.load(), DeviceState::kStreaming);
  EXPECT_FALSE(rig.base->imuStatus().problem());
}

TEST(SerialBase, DoesNotTakeTheNumberOfASpeedBeforeItForItsOwn) {
  BaseRig rig("frame");
  ASSERT_TRUE(rig.connect());
  std::uint8_t frame[slamd_base::kLongestFrame];
  for (const int number : {1, 2, 255}) {
    rig.base.reset();
    // Of a slamd that was killed: the base has its speed, and its number.
    BaseRig::Bytes out;
    const std::size_t size = slamd_base::encodeSpeeds({static_cast<std::uint8_t>(number), {500, 500}}, frame);
    rig.emulator->exchange({frame, size}, virtual_now, out);
    rig.emulator->inject("deaf", 1.0);
    rig.start();
    const std::size_t before = rig.written.size();
    rig.runFor(1s);
    EXPECT_GT(rig.written.size(), before + 10 * size) << "its zero is sent again and again";
    rig.emulator->inject("deaf", 0.0);
    rig.runFor(500ms);
    const std::size_t known = rig.written.size();
    rig.runFor(1s);
    EXPECT_EQ(rig.written.size(), known);
  }
}

TEST(SerialBase, StopsByItselfWhereTheReferenceFirmwareGetsNothing) {
  BaseRig rig("frame");
  ASSERT_TRUE(rig.connect());
  rig.driveFor(1s, {.vx = 0.3});
  ASSERT_FALSE(rig.stands());
  rig.emulator->inject("deaf", 1.0);
  EXPECT_LE(rig.timeToStop(), 1ms * slamd_base::kCommandLasts + 20ms);
}

TEST(SerialBase, SetsTheTimeoutThatARoboclawHasNotAsDelivered) {
  BaseRig rig("roboclaw");
  ASSERT_TRUE(rig.connect());
  rig.driveFor(1s, {.vx = 0.3});
  rig.kill();
  ASSERT_FALSE(rig.stands()) << "nobody has stopped it yet";
  const Timestamp killed = virtual_now;
  while (!rig.stands() && virtual_now < killed + 2s) rig.line.pass(10ms);
  EXPECT_LE(virtual_now - killed, 500ms);
  rig.start();
  ASSERT_TRUE(rig.connect());
  rig.emulator->inject("reset", 1.0);  // its timeout is off again, as nothing shows
  rig.runFor(1500ms);
  rig.driveFor(1s, {.vx = 0.3});
  rig.kill();
  for (const Timestamp end = virtual_now + 500ms; virtual_now < end;) rig.line.pass(10ms);
  EXPECT_TRUE(rig.stands());
}

TEST(SerialBase, LeavesTheTimeoutOfARoboclawThatItMayNotDrive) {
  BaseRig rig("roboclaw");
  rig.start(false);
  ASSERT_TRUE(rig.connect());
  rig.written.clear();
  rig.runFor(3s);
  EXPECT_THAT(rig.written, testing::Not(testing::Contains(14)));
}

TEST(SerialBase, StopsBothWheelsWhereTheSecondVescIsGone) {
  BaseRig rig("vesc");
  ASSERT_TRUE(rig.connect());
  rig.driveFor(2s, {.vx = 0.3});
  EXPECT_GT(rig.base->battery(), 24.0F);
  rig.emulator->inject("cut", 1.0);
  rig.driveFor(500ms, {.vx = 0.3});
  EXPECT_TRUE(rig.has(problem::kVescAway)) << rig.words();
  EXPECT_EQ(rig.state(), DeviceState::kFault);
  EXPECT_NEAR(rig.emulator->drive().omega, 0.15 / rig.geometry.base.half_track, 0.01)
      << "the left wheel stands, the other one's own time is not up yet";
  rig.driveFor(1s, {.vx = 0.3});
  EXPECT_TRUE(rig.stands()) << "whatever is asked for";
  rig.emulator->inject("cut", 0.0);
  rig.runFor(1s);
  EXPECT_EQ(rig.state(), DeviceState::kStreaming) << rig.words();
  EXPECT_TRUE(rig.stands());
  rig.driveFor(500ms, {.vx = 0.3});
  EXPECT_FALSE(rig.stands());
  EXPECT_FALSE(rig.base->wheelStatus().problem()) << rig.words();
}

TEST(SerialBase, StopsBothWheelsAtTheFaultOfAVesc) {
  BaseRig rig("vesc");
  ASSERT_TRUE(rig.connect());
  rig.driveFor(2s, {.vx = 0.3});
  rig.emulator->inject("fault", 2.0);
  rig.driveFor(300ms, {.vx = 0.3});
  EXPECT_TRUE(rig.has(problem::kVescFault)) << rig.words();
  EXPECT_TRUE(rig.stands()) << "the one without a fault, too";
  rig.emulator->inject("fault", 0.0);
  rig.driveFor(300ms, {.vx = 0.3});
  EXPECT_FALSE(rig.stands());
  EXPECT_FALSE(rig.base->wheelStatus().problem()) << rig.words();
}

TEST(SerialBase, SendsAVescNothingButZerosUntilBothAreKnown) {
  BaseRig rig("vesc");
  rig.emulator->inject("cut", 1.0);
  rig.driveFor(2s, {.vx = 0.3});
  EXPECT_TRUE(rig.stands());
  EXPECT_TRUE(rig.has(problem::kVescAway)) << rig.words();
  rig.emulator->inject("silent", 1.0);
  rig.driveFor(2s, {.vx = 0.3});
  rig.emulator->inject("silent", 0.0);
  EXPECT_TRUE(rig.stands());
}

TEST(SerialBase, EntersACreatesSafeModeForACommandAlone) {
  BaseRig rig("create");
  ASSERT_TRUE(rig.connect());
  rig.runFor(3s);
  EXPECT_THAT(rig.written, testing::Not(testing::Contains(131))) << "no mode in which a motor obeys";
  rig.driveFor(300ms, {.vx = 0.2});
  EXPECT_THAT(rig.written, testing::Contains(131));
  EXPECT_THAT(rig.written, testing::Not(testing::Contains(132))) << "full mode has no protection";
  EXPECT_FALSE(rig.stands());
}

TEST(SerialBase, IsNeverAskedWhatACreateTakesForPressedButtons) {
  BaseRig rig("create");
  rig.emulator->inject("silent", 1.0);
  ASSERT_TRUE(rig.runUntil([&] { return rig.state() == DeviceState::kFault; }));
  rig.runFor(10s);
  EXPECT_THAT(rig.written, testing::Not(testing::Contains(0xA5)));
}

TEST(SerialBase, LeavesAnArduinosBootloaderInPeace) {
  BaseRig rig("text");
  rig.emulator->loseItsPlug();
  const Timestamp opened = virtual_now;
  rig.runFor(400ms);
  const std::size_t written = rig.written.size();
  rig.runFor(1500ms);
  EXPECT_EQ(rig.written.size(), written);
  ASSERT_TRUE(rig.connect()) << rig.words();
  EXPECT_LT(virtual_now - opened, 2500ms);
}

TEST(SerialBase, DoesNotTakeALateAnswerForThatToTheZero) {
  BaseRig rig("text");
  ASSERT_TRUE(rig.connect());
  rig.driveFor(1s, {.vx = 0.3});
  rig.delay = 130ms;  // each answer comes when its request has been given up
  rig.driveFor(1s, {.vx = 0.3});
  rig.emulator->inject("deaf", 1.0);
  rig.runFor(700ms);
  rig.delay = Duration(0);
  rig.emulator->inject("deaf", 0.0);
  EXPECT_LE(rig.timeToStop(), 150ms);
}

}  // namespace
}  // namespace slam::serial_base_test
