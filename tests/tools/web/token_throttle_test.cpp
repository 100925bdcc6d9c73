// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/token_throttle.hpp"

#include <gtest/gtest.h>

namespace slam::token_throttle_test {
namespace {

using namespace std::chrono_literals;

class Throttled : public testing::Test {
 protected:
  /// Guesses as often as it may. @return how often within that time
  int guesses(const std::string& address, Duration time) {
    int count = 0;
    for (const Timestamp end = now + time; now < end; ++count) {
      now += throttle.wait(address, now);
      throttle.wrong(address, now);
    }
    return count;
  }

  TokenThrottle throttle{{.free = 5, .first = 1s, .longest = 60s, .forgotten = 10min, .most = 3}};
  Timestamp now{1000s};
};

TEST_F(Throttled, ForgivesATypingError) {
  for (int i = 0; i < 5; ++i) {
    throttle.wrong("a", now);
    EXPECT_EQ(throttle.wait("a", now), 0s);
  }
  throttle.right("a");
  for (int i = 0; i < 5; ++i) throttle.wrong("a", now);
  EXPECT_EQ(throttle.wait("a", now), 0s);
}

TEST_F(Throttled, LetsNobodyGuessMuchInADay) {
  const int day = guesses("a", 24h);
  EXPECT_GT(day, 1400);
  EXPECT_LT(day, 1500);
  EXPECT_EQ(throttle.wait("b", now), 0s) << "of another address";
  EXPECT_GT(throttle.wait("a", now), 59s);
  now += 11min;
  throttle.wrong("a", now);
  EXPECT_EQ(throttle.wait("a", now), 0s) << "forgotten";
}

TEST_F(Throttled, RemembersSoManyAddressesAndNoMore) {
  for (int i = 0; i < 10; ++i) throttle.wrong("guesser", now += 1s);
  EXPECT_GT(throttle.wait("guesser", now), 0s);
  for (int i = 0; i < 100; ++i) {
    throttle.wrong(std::to_string(i), now += 1ms);
    throttle.wrong("guesser", now);
  }
  EXPECT_GT(throttle.wait("guesser", now), 0s) << "the one that guesses on";
}

}  // namespace
}  // namespace slam::token_throttle_test
