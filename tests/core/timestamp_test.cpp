// SPDX-License-Identifier: BSD-3-Clause
#include "core/timestamp.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace slam::timestamp_test {
namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;

template <typename Clock>
concept CanTellTheTime = requires {
  Clock::now();
};
static_assert(!CanTellTheTime<MonotonicClock>, "a clock with now() would make code depend on when it runs");

TEST(Timestamp, SecondsAreRoundedToTheNearestNanosecondOnBothSidesOfZero) {
  EXPECT_EQ(fromSeconds(1.6e-9), nanoseconds(2));
  EXPECT_EQ(fromSeconds(1.4e-9), nanoseconds(1));
  EXPECT_EQ(fromSeconds(-1.6e-9), nanoseconds(-2));
  EXPECT_EQ(fromSeconds(-1.4e-9), nanoseconds(-1));
  EXPECT_EQ(fromSeconds(0.3), nanoseconds(300'000'000));  // 0.3 * 1e9 is not an integer in binary
}

TEST(Timestamp, SecondsSurviveTheRoundTripToANanosecond) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> seconds(-1e5, 1e5);
  for (int i = 0; i < 1000; ++i) {
    const double s = seconds(random);
    EXPECT_NEAR(toSeconds(fromSeconds(s)), s, 1e-9);
  }
}

TEST(Timestamp, MicrosecondsSurviveTheRoundTripExactly) {
  constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max() / 1000;
  for (const std::int64_t utime :
       {std::int64_t{0}, std::int64_t{1}, std::int64_t{-1}, std::int64_t{1'700'000'000'000'000}, kLargest, -kLargest})
    EXPECT_EQ(toMicroseconds(fromMicroseconds(utime)), utime);
}

TEST(Timestamp, MicrosecondsAreRoundedDownAlsoBeforeTheEpoch) {
  EXPECT_EQ(toMicroseconds(Timestamp(nanoseconds(1999))), 1);
  EXPECT_EQ(toMicroseconds(Timestamp(nanoseconds(-1))), -1);
  EXPECT_EQ(toMicroseconds(Timestamp(nanoseconds(-1000))), -1);
  EXPECT_EQ(toMicroseconds(Timestamp(nanoseconds(-1001))), -2);
}

}  // namespace
}  // namespace slam::timestamp_test
