// SPDX-License-Identifier: BSD-3-Clause
#include "timing/sample_clock.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace slam::sample_clock_test {
namespace {

using namespace std::chrono_literals;
constexpr Duration kPeriod = 250us;
constexpr Timestamp kStart{100s};

TEST(SampleClock, FindsTheLeastDelayUnderJitterAndNeverGoesBack) {
  SampleClock clock(toSeconds(kPeriod));
  std::mt19937 random(1);
  std::exponential_distribution<double> delay(1.0 / 0.002);  // 2 ms mean, now and then much more
  Timestamp last{};
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const Timestamp taken = kStart + i * kPeriod;
    const Timestamp stamp = clock.stamp(taken + fromSeconds(std::min(0.02, delay(random))));
    EXPECT_GE(stamp, last);
    last = stamp;
    if (i > 4000) worst = std::max(worst, std::abs(toSeconds(stamp - taken)));
  }
  EXPECT_LT(worst, 0.001);
}

TEST(SampleClock, BeginsAnewBehindAGap) {
  SampleClock clock(toSeconds(kPeriod));
  clock.stamp(kStart);
  EXPECT_EQ(clock.stamp(kStart + 2s), kStart + 2s);
}

TEST(SampleClock, FollowsADeviceThatRunsSlow) {
  SampleClock clock(toSeconds(kPeriod));
  Timestamp stamp{};
  const Duration real = kPeriod * 1003 / 1000;
  for (int i = 0; i < 40000; ++i) stamp = clock.stamp(kStart + i * real);
  EXPECT_LT(std::abs(toSeconds(stamp - (kStart + 39999 * real))), 0.001);
}

TEST(SampleClock, GoesOnBehindSamplesThatAreKnownToBeLost) {
  SampleClock clock(toSeconds(kPeriod));
  for (int i = 0; i < 100; ++i) clock.stamp(kStart + i * kPeriod);
  // 500 samples are lost, longer than a gap, and the next one arrives 5 ms late: late is not lost.
  const Timestamp taken = kStart + 600 * kPeriod;
  EXPECT_LT(std::abs(toSeconds(clock.stamp(taken + 5ms, 500) - taken)), 0.001);
}

TEST(SampleClock, ABurstBehindAHoldUpIsStampedAsIfItHadComeInTime) {
  SampleClock clock(toSeconds(kPeriod));
  for (int i = 0; i < 4000; ++i) clock.stamp(kStart + i * kPeriod);
  const Timestamp read = kStart + 4320 * kPeriod;  // 80 ms of samples at once
  for (int i = 4000; i < 4320; ++i) {
    EXPECT_LT(std::abs(toSeconds(clock.stamp(read) - (kStart + i * kPeriod))), 0.001) << i;
  }
}

TEST(SampleClock, FindsBackAfterAnUnannouncedLoss) {
  SampleClock clock(toSeconds(kPeriod));
  for (int i = 0; i < 4000; ++i) clock.stamp(kStart + i * kPeriod);
  Timestamp stamp{};
  for (int i = 4160; i < 6000; ++i) stamp = clock.stamp(kStart + i * kPeriod);  // 40 ms are missing
  EXPECT_LT(std::abs(toSeconds(stamp - (kStart + 5999 * kPeriod))), 0.002);
}

}  // namespace
}  // namespace slam::sample_clock_test
