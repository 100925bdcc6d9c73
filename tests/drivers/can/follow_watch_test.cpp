// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/follow_watch.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace slam::follow_watch_test {
namespace {

using namespace std::chrono_literals;
using Speeds = FollowWatch::Speeds;

class FollowWatchTest : public testing::Test {
 protected:
  void run(Duration time, const Speeds& asked, const Speeds& measured, Duration period = 10ms) {
    for (std::size_t side = 0; side < 2; ++side) watch_.ask(side, asked[side]);
    for (const Timestamp end = now_ + time; now_ < end; now_ += 5ms) watch_.add(now_, measured, period);
  }
  /// Drives whose ramps gain so much [turns/s^2].
  void ramp(Duration time, const Speeds& asked, double gain) {
    for (const Timestamp end = now_ + time; now_ < end; now_ += 5ms) {
      for (std::size_t side = 0; side < 2; ++side)
        measured_[side] += std::clamp(asked[side] - measured_[side], -0.005 * gain, 0.005 * gain);
      for (std::size_t side = 0; side < 2; ++side) watch_.ask(side, asked[side]);
      watch_.add(now_, measured_, 10ms);
    }
  }
  FollowWatch watch_;
  Timestamp now_{1000s};
  Speeds measured_{};
};

TEST_F(FollowWatchTest, FindsTheWheelThatDoesNotTurnWhileTheOtherOneDoes) {
  for (const double way : {1.0, -1.0}) {
    for (const std::size_t side : {0U, 1U}) {
      watch_ = {};
      Speeds measured{way, way};
      run(5s, {way, way}, measured);
      EXPECT_FALSE(watch_.idle());
      measured[side] = 0.1 * way;
      run(290ms, {way, way}, measured);
      EXPECT_FALSE(watch_.idle());
      run(20ms, {way, way}, measured);
      EXPECT_EQ(watch_.idle(), side);
    }
  }
  watch_.forget();
  EXPECT_FALSE(watch_.idle());
}

TEST_F(FollowWatchTest, FindsOneThatTurnsTheOtherWay) {
  run(400ms, {0.5, -0.5}, {0.5, 0.5});
  EXPECT_EQ(watch_.idle(), 1U);
}

TEST_F(FollowWatchTest, LeavesARobotAloneThatStandsOrTurnsAboutOneWheel) {
  run(5s, {1.0, 1.0}, {0.0, 0.0});  // at a wall
  run(5s, {1.0, 0.0}, {1.0, 0.0});
  run(5s, {1.0, 0.05}, {1.0, 0.0});  // friction
  run(5s, {1.0, 1.0}, {1.0, 0.4});   // uphill, or slipping
  run(5s, {0.0, 0.0}, {1.0, -1.0});  // pushed
  EXPECT_FALSE(watch_.idle());
}

TEST_F(FollowWatchTest, LeavesWheelsAloneThatAreOnTheirWay) {
  for (const double gain : {0.4, 1.0, 10.0}) {
    measured_ = {};
    ramp(5s, {1.0, 1.0}, gain);
    ramp(10s, {1.0, -1.0}, gain);
    ramp(10s, {-1.0, 1.0}, gain);
    EXPECT_FALSE(watch_.idle()) << gain;
  }
}

TEST_F(FollowWatchTest, CountsOnlyTimeInWhichSomebodyDrives) {
  for (int i = 0; i < 20; ++i) {
    run(200ms, {1.0, 1.0}, {1.0, 0.0});
    watch_.rest();
  }
  EXPECT_FALSE(watch_.idle());
}

TEST_F(FollowWatchTest, WaitsForSeveralMeasurements) {
  run(550ms, {1.0, 1.0}, {1.0, 0.0}, 200ms);
  EXPECT_FALSE(watch_.idle());
  run(100ms, {1.0, 1.0}, {1.0, 0.0}, 200ms);
  EXPECT_EQ(watch_.idle(), 1U);
}

}  // namespace
}  // namespace slam::follow_watch_test
