// SPDX-License-Identifier: BSD-3-Clause
// Whether the robot stops, whatever happens to the line, to the board and to slamd. The board of these tests has no
// watchdog.
#include <gtest/gtest.h>

#include "drivers/board/handsfree_fixture.hpp"

namespace slam::handsfree_stop_test {
namespace {

using namespace std::chrono_literals;
using test::virtual_now;

class HandsfreeStop : public test::HandsfreeBoardTest {
 protected:
  HandsfreeStop() { startSlamd(); }
  void startSlamd() { make({.may_drive = true}); }
  /// As one that is killed: it says nothing at its end.
  void killSlamd() {
    fake_.lost_speeds = 1000;
    fake_.answers = false;
    driver_.reset();
    fake_.serve();
    fake_.lost_speeds = 0;
    fake_.answers = true;
  }
  bool stands() const { return fake_.speed.x == 0.0F && fake_.speed.z == 0.0F; }
  void startDriving() {
    ASSERT_TRUE(runUntil([&] { return streaming(); }));
    ASSERT_TRUE(runUntil([&] {
      driver_->command(0.2, 0.0, 0.5);
      return !stands();
    }));
  }
  /// @return how long it went on driving
  Duration timeToStop() {
    const Timestamp begin = virtual_now;
    EXPECT_TRUE(runUntil([&] { return stands(); }));
    return virtual_now - begin;
  }
};

TEST_F(HandsfreeStop, IsSentByASlamdThatNeverHadACommand) {
  startDriving();
  killSlamd();
  startSlamd();
  ASSERT_FALSE(stands());
  EXPECT_LE(timeToStop(), 100ms);
}

TEST_F(HandsfreeStop, IsSentWhenThePortIsBackAlthoughTheCommandBecameOldLongBefore) {
  startDriving();
  fake_.line().unplug();
  runFor(3s);
  ASSERT_FALSE(stands());
  fake_.line().plug();
  EXPECT_LE(timeToStop(), 100ms);
}

TEST_F(HandsfreeStop, IsSentWhenTheBoardAnswersAgain) {
  for (const Duration mute : {Duration(150ms), Duration(1s), Duration(2s), Duration(6s)}) {
    startDriving();
    fake_.mute = true;
    runFor(mute);
    fake_.mute = false;
    runFor(mute < 500ms ? 500ms - mute : Duration(0));
    EXPECT_LE(timeToStop(), 200ms) << "the request that was under way is given up after 100 ms";
  }
}

TEST_F(HandsfreeStop, IsSentAfterAResetOfTheBoard) {
  startDriving();
  runFor(2s);
  ASSERT_TRUE(stands());
  fake_.restart();
  fake_.speed.x = 0.3F;
  EXPECT_LE(timeToStop(), 100ms);
}

TEST_F(HandsfreeStop, IsRepeatedUntilTheBoardAcknowledgesIt) {
  startDriving();
  runFor(400ms);
  fake_.lost_speeds = 7;
  runFor(3s);
  EXPECT_TRUE(stands());
  EXPECT_EQ(fake_.lost_speeds, 0);
  const std::size_t drives = fake_.drives.size();
  runFor(10s);
  EXPECT_EQ(fake_.drives.size(), drives) << "it was acknowledged";
}

TEST_F(HandsfreeStop, IsSentToABoardWhoseAnswersAreLost) {
  startDriving();
  fake_.answers = false;
  runFor(500ms);
  EXPECT_LE(timeToStop(), 200ms);
}

TEST_F(HandsfreeStop, IsOwedAnewWhereAnotherMayHaveDrivenTheRobotMeanwhile) {
  startDriving();
  runFor(3s);
  ASSERT_TRUE(stands());
  fake_.line().unplug();
  runFor(1s);
  fake_.speed.x = 0.3F;
  fake_.line().plug();
  EXPECT_LE(timeToStop(), 100ms);
  ASSERT_TRUE(runUntil([&] { return streaming(); }));
  fake_.mute = true;
  runFor(150ms);
  fake_.speed.x = 0.3F;
  fake_.mute = false;
  EXPECT_LE(timeToStop(), 200ms);
}

TEST_F(HandsfreeStop, GivesWayToAFreshCommand) {
  startDriving();
  fake_.line().unplug();
  runFor(3s);
  fake_.drives.clear();
  fake_.line().plug();
  ASSERT_TRUE(runUntil([&] {
    driver_->command(0.4, 0.0, 0.0);
    return !fake_.drives.empty();
  }));
  EXPECT_EQ(fake_.drives.front().speed.x, 0.4F);
}

TEST_F(HandsfreeStop, IsNotReplacedByACommandThatIsOldAlready) {
  ASSERT_TRUE(driver_->command(0.4, 0.0, 0.0, virtual_now - 501ms));
  runFor(2s);
  ASSERT_FALSE(fake_.drives.empty());
  for (const auto& drive : fake_.drives) EXPECT_EQ(drive.speed.x, 0.0F);
}

TEST_F(HandsfreeStop, AtTheEndIsSentAgainUntilItIsAcknowledged) {
  startDriving();
  fake_.lost_speeds = 3;
  driver_->stop();
  fake_.serve();
  EXPECT_EQ(fake_.lost_speeds, 0);
  EXPECT_TRUE(stands());
}

}  // namespace
}  // namespace slam::handsfree_stop_test
