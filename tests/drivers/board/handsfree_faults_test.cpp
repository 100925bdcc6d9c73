// SPDX-License-Identifier: BSD-3-Clause
// What the driver makes of a board that fails, or says what cannot be.
#include <algorithm>
#include <gtest/gtest.h>
#include <limits>

#include "drivers/board/handsfree_fixture.hpp"

namespace slam::handsfree_faults_test {
namespace {

using std::chrono::milliseconds;
using test::FakeBoard;
using test::HandsfreeBoardTest;
using test::virtual_now;

TEST_F(HandsfreeBoardTest, MarksTheFirstReadingAfterABoardReset) {
  ASSERT_TRUE(runUntilWheels(10));
  const std::size_t before = wheels_.size();
  fake_.restart();
  ASSERT_TRUE(runUntilWheels(10));
  EXPECT_EQ(fake_.handshakes, 2);
  EXPECT_TRUE(wheels_[before].restarted);
  EXPECT_LT(wheels_[before].angles[0], wheels_[before - 1].angles[0]) << "counts from zero again";
  for (std::size_t i = before + 1; i < wheels_.size(); ++i) EXPECT_FALSE(wheels_[i].restarted);
}

TEST_F(HandsfreeBoardTest, UsesAnswersBetweenNoise) {
  fake_.before_answers = {0xFF, 0x00, 0x55, 0xFF, 0xFF, 0x11, 0x01, 0x00, 0x01, 0x10, 0xAA, 0xFF};
  ASSERT_TRUE(runUntilWheels(10));
  EXPECT_TRUE(runUntil([&] { return imu_.size() >= 10; }));
  EXPECT_GT(driver_->wheelStatus().rejects.load() + driver_->imuStatus().rejects.load(), 0) << "damage is counted";
}

TEST_F(HandsfreeBoardTest, RejectsAReadingThatIsNotANumber) {
  fake_.imu.gyro[1] = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(runUntilWheels(10));
  ASSERT_TRUE(runUntil([&] { return driver_->imuStatus().rejects.load() > 0; }));
  EXPECT_TRUE(imu_.empty());
}

TEST_F(HandsfreeBoardTest, HasNoImuWhenTheUnitIsOffline) {
  fake_.imu.online = 0;
  ASSERT_TRUE(runUntilWheels(30));
  EXPECT_TRUE(imu_.empty());
  EXPECT_NE(driver_->imuStatus().state.load(), DeviceState::kStreaming);
  EXPECT_EQ(driver_->wheelStatus().state.load(), DeviceState::kStreaming);
}

TEST_F(HandsfreeBoardTest, ThatFallsSilentIsStaleThenAFaultThenUsedAgain) {
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
  wheel_states_.clear(), imu_states_.clear();
  fake_.mute = true;
  ASSERT_TRUE(runUntil([&] { return faulty(); }));
  for (const auto& states : {wheel_states_, imu_states_}) {
    const auto stale = std::find(states.begin(), states.end(), DeviceState::kStale);
    EXPECT_NE(std::find(stale, states.end(), DeviceState::kFault), states.end());
  }
  fake_.mute = false;
  const auto wheels = wheels_.size(), imu = imu_.size();
  ASSERT_TRUE(runUntil([&] { return streaming() && wheels_.size() > wheels && imu_.size() > imu; }));
}

TEST_F(HandsfreeBoardTest, ThatNeverAnswersBecomesAFaultAndIsUsedWhenItDoes) {
  fake_.mute = true;
  ASSERT_TRUE(runUntil([&] { return faulty(); }));
  EXPECT_TRUE(wheels_.empty());
  fake_.mute = false;
  ASSERT_TRUE(runUntil([&] { return streaming() && !wheels_.empty() && !imu_.empty(); }));
  EXPECT_TRUE(wheels_.front().restarted);
}

TEST_F(HandsfreeBoardTest, NoticesAHangUpAndTheReturnOfTheDevice) {
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
  fake_.line().unplug();
  fake_.restart();
  ASSERT_TRUE(runUntil([&] { return driver_->wheelStatus().state != DeviceState::kStreaming; }));
  EXPECT_NE(driver_->imuStatus().state.load(), DeviceState::kStreaming);
  const std::size_t before = wheels_.size();
  fake_.line().plug();
  ASSERT_TRUE(runUntil([&] { return streaming() && wheels_.size() > before; }));
  EXPECT_TRUE(wheels_[before].restarted);
}

TEST_F(HandsfreeBoardTest, IsAbsentWithoutAPort) {
  fake_.line().unplug();
  ASSERT_TRUE(runUntil([&] { return driver_->wheelStatus().state != DeviceState::kOpening; }));
  for (int i = 0; i < 10; ++i) driver_->tick();
  EXPECT_EQ(driver_->wheelStatus().state.load(), DeviceState::kAbsent);
  EXPECT_EQ(driver_->imuStatus().state.load(), DeviceState::kAbsent);
  EXPECT_NE(driver_->wheelStatus().problem().words(), "");
}

TEST_F(HandsfreeBoardTest, GoesOnCountingOverALostPort) {
  ASSERT_TRUE(runUntilWheels(10));
  fake_.line().unplug();
  ASSERT_TRUE(runUntil([&] { return driver_->wheelStatus().state == DeviceState::kAbsent; }));
  const std::size_t before = wheels_.size();
  fake_.line().plug();
  ASSERT_TRUE(runUntilWheels(1));
  EXPECT_FALSE(wheels_[before].restarted) << "the board kept its power: nothing was missed";
  EXPECT_EQ(fake_.handshakes, 1);
}

TEST_F(HandsfreeBoardTest, InventsNoMotionFromAJumpOfTheCounter) {
  ASSERT_TRUE(runUntilWheels(10));
  const std::size_t before = wheels_.size();
  fake_.mileage[1] += 500.0F;
  ASSERT_TRUE(runUntilWheels(2));
  EXPECT_TRUE(wheels_[before].restarted);
  EXPECT_FALSE(wheels_[before + 1].restarted);
}

TEST_F(HandsfreeBoardTest, InventsNoMotionFromACounterThatIsNotANumber) {
  ASSERT_TRUE(runUntilWheels(10));
  const std::int64_t rejects = driver_->wheelStatus().rejects;
  const std::size_t before = wheels_.size();
  fake_.mileage[1] = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(runUntil([&] { return driver_->wheelStatus().rejects > rejects; }));
  EXPECT_EQ(wheels_.size(), before);
  fake_.mileage[1] = 0.25F;
  ASSERT_TRUE(runUntilWheels(1));
  EXPECT_TRUE(wheels_[before].restarted);
}

TEST_F(HandsfreeBoardTest, SurvivesMissedPollsWithoutLosingTheWay) {
  ASSERT_TRUE(runUntilWheels(10));
  const std::size_t before = wheels_.size();
  fake_.mute = true;
  runFor(milliseconds(400));
  for (std::size_t i = 0; i < 4; ++i) fake_.mileage[i] += 30 * fake_.step[i];
  fake_.mute = false;
  ASSERT_TRUE(runUntilWheels(5));
  EXPECT_NEAR(wheels_.back().angles[0], -static_cast<double>(fake_.mileage[0]), 1e-6);
  for (std::size_t i = before; i < wheels_.size(); ++i) EXPECT_FALSE(wheels_[i].restarted);
}

struct Trouble {
  const char* name;
  std::function<void(FakeBoard&)> begin, end;
  const char* words;
};
class InTrouble : public HandsfreeBoardTest, public testing::WithParamInterface<Trouble> {};

TEST_P(InTrouble, ReportsItWithinASecondAndStreamsAgainWithinThree) {
  ASSERT_TRUE(runUntil([&] { return streaming() && wheels_.size() > 100; }));
  GetParam().begin(fake_);
  const Timestamp begin = virtual_now;
  ASSERT_TRUE(runUntil([&] { return driver_->imuStatus().state != DeviceState::kStreaming; }));
  EXPECT_LE(virtual_now - begin, std::chrono::seconds(1));
  EXPECT_EQ(driver_->imuStatus().problem().words(), GetParam().words);
  runFor(std::chrono::seconds(6));
  GetParam().end(fake_);
  const Timestamp end = virtual_now;
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
  EXPECT_LE(virtual_now - end, std::chrono::seconds(3));
}

INSTANTIATE_TEST_SUITE_P(
    Of, InTrouble,
    testing::Values(Trouble{"Silence", [](FakeBoard& f) { f.mute = true; }, [](FakeBoard& f) { f.mute = false; },
                            "the board does not answer: check its power"},
                    Trouble{"Babble", [](FakeBoard& f) { f.mute = f.babble = true; },
                            [](FakeBoard& f) { f.mute = f.babble = false; },
                            "the board's answers cannot be read: check baud rate and cable"},
                    Trouble{"Unplugging", [](FakeBoard& f) { f.line().unplug(); },
                            [](FakeBoard& f) { f.line().plug(); }, "the port is gone: unplugged?"},
                    Trouble{"ImuOffline", [](FakeBoard& f) { f.imu.online = 0; },
                            [](FakeBoard& f) { f.imu.online = 1; },
                            "the board says that its IMU is offline: restart the board, and check its IMU's cable"},
                    Trouble{"ImuStuck", [](FakeBoard& f) { f.renew = [] {}; }, [](FakeBoard& f) { f.renew = nullptr; },
                            "the board answers, but its IMU values never change: restart it"}),
    [](const auto& instance) { return instance.param.name; });

/// Answers that come late are taken for those of later requests now and then, whatever the last one was.
TEST_F(HandsfreeBoardTest, ReportsThatAnswersComeTooLateHoweverLate) {
  constexpr const char* kWords = "the board's answers come too late: is something else on its link (USB hub, cable)?";
  for (int delay = 110; delay <= 190; delay += 5) {
    ASSERT_TRUE(runUntil([&] { return streaming(); }));
    fake_.delay = milliseconds(delay);
    const Timestamp begin = virtual_now;
    const auto noticed = [](const DeviceStatus& status) { return status.state != DeviceState::kStreaming; };
    ASSERT_TRUE(runUntil([&] { return noticed(driver_->wheelStatus()) && noticed(driver_->imuStatus()); }));
    EXPECT_LE(virtual_now - begin, std::chrono::seconds(1)) << delay << " ms";
    EXPECT_EQ(driver_->wheelStatus().problem().words(), kWords) << delay << " ms";
    EXPECT_EQ(driver_->imuStatus().problem().words(), kWords) << delay << " ms";
    fake_.delay = {};
  }
}

TEST_F(HandsfreeBoardTest, TakesNoStandingWheelsFromABoardThatRenewsNothing) {
  ASSERT_TRUE(runUntil([&] { return streaming() && wheels_.size() > 300; }));
  fake_.time_runs = false;
  fake_.step = {};
  fake_.renew = [] {};
  const Timestamp begin = virtual_now;
  ASSERT_TRUE(runUntil([&] { return driver_->wheelStatus().state != DeviceState::kStreaming; }));
  EXPECT_EQ(driver_->wheelStatus().problem().words(), "the board answers, but renews nothing any more: restart it");
  EXPECT_GT(virtual_now - begin, milliseconds(200)) << "a hiccup is no fault";
  EXPECT_LT(virtual_now - begin, milliseconds(900));
  const std::size_t before = wheels_.size();
  runFor(std::chrono::seconds(5));
  EXPECT_EQ(wheels_.size(), before);
  fake_.time_runs = true;
  fake_.renew = nullptr;
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
}

TEST_F(HandsfreeBoardTest, TakesABoardWhoseClockIsCoarseAfterLongForARunningOne) {
  virtual_now += std::chrono::hours(24 * 365);  // the board counts microseconds in a float: its steps are seconds now
  ASSERT_TRUE(runUntil([&] { return streaming() && wheels_.size() > 20; }));
  for (int i = 0; i < 200; ++i) {
    runFor(milliseconds(50));
    ASSERT_EQ(driver_->wheelStatus().state, DeviceState::kStreaming) << driver_->wheelStatus().problem().words();
  }
}

}  // namespace
}  // namespace slam::handsfree_faults_test
