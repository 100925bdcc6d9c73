// SPDX-License-Identifier: BSD-3-Clause
#include "bus/freshness.hpp"

#include <gtest/gtest.h>

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kNow{1000s};

TEST(Freshness, ASpeedAskedForHalfASecondAgoIsNotDriven) {
  EXPECT_TRUE(isFreshCommand(kNow, kNow));
  EXPECT_TRUE(isFreshCommand(kNow - 499ms, kNow));
  EXPECT_FALSE(isFreshCommand(kNow - 500ms, kNow));
  EXPECT_FALSE(isFreshCommand(kNow - 2s, kNow));
  EXPECT_FALSE(isFreshCommand(Timestamp{}, kNow)) << "a sender without a clock";
}

TEST(Freshness, ASpeedFromAClockThatIsAheadIsDrivenUpToASecond) {
  EXPECT_TRUE(isFreshCommand(kNow + 999ms, kNow));
  EXPECT_FALSE(isFreshCommand(kNow + 1s, kNow));
  EXPECT_FALSE(isFreshCommand(kNow + 3600s, kNow));
}

TEST(Freshness, ASampleMayBeOldButNotFromTheFuture) {
  EXPECT_TRUE(isPossible(kNow - 3600s, kNow));
  EXPECT_TRUE(isPossible(kNow + 1s, kNow));
  EXPECT_FALSE(isPossible(kNow + 1s + 1us, kNow));
}

}  // namespace
}  // namespace slam
