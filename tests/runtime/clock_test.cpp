// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/clock.hpp"

#include <ctime>
#include <gtest/gtest.h>

namespace slam::clock_test {
namespace {

Timestamp systemClock(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return Timestamp(std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec));
}

TEST(MonotonicNow, IsTheSystemsMonotonicClock) {
  for (int i = 0; i < 1000; ++i) {
    const Timestamp before = systemClock(CLOCK_MONOTONIC);
    const Timestamp now = monotonicNow();
    EXPECT_LE(before, now);
    EXPECT_LE(now, systemClock(CLOCK_MONOTONIC));
  }
}

TEST(WallClock, GivesTheTimeOfDayOfAStamp) {
  const WallClock wall;
  const std::int64_t real = toMicroseconds(systemClock(CLOCK_REALTIME));
  EXPECT_NEAR(static_cast<double>(wall.utime(monotonicNow()) - real), 0.0, 1e6);
}

TEST(WallClock, MapsThereAndBackByOneOffset) {
  const WallClock wall;
  const Timestamp stamp = fromMicroseconds(123'456'789);
  const Timestamp back = wall.stamp(wall.utime(stamp));
  EXPECT_LE(std::chrono::abs(back - stamp), std::chrono::microseconds(1));
  EXPECT_EQ(wall.utime(stamp + std::chrono::seconds(5)) - wall.utime(stamp), 5'000'000);
  EXPECT_LT(std::chrono::abs(wall.drift()), std::chrono::seconds(1));
}

TEST(WallClock, FollowsAStepWithStampsThatGrow) {
  WallClock wall;
  const Timestamp stamp = monotonicNow();
  const std::int64_t before = wall.utime(stamp);
  wall.follow(std::chrono::hours(24));
  EXPECT_EQ(wall.utime(stamp) - before, 86'400'000'000);
  EXPECT_EQ(wall.followed(), std::chrono::hours(24));
  EXPECT_LE(std::chrono::abs(wall.stamp(wall.utime(stamp)) - stamp), std::chrono::microseconds(1));
  EXPECT_LT(wall.drift(), std::chrono::hours(-23)) << "the wall clock itself was not set";
}

}  // namespace
}  // namespace slam::clock_test
