// SPDX-License-Identifier: BSD-3-Clause
#include "bus/freshness.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slam::freshness_test {
namespace {

using testing::StartsWith;
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

TEST(StampProblem, GivesTheAgeOfALogThatIsPlayed) {
  EXPECT_FALSE(stampProblem(0s, false));
  EXPECT_FALSE(stampProblem(4900ms, false));
  EXPECT_THAT(stampProblem(600s, false).words(), StartsWith("stamps are 600 s old: use slam-replay"));
}

TEST(StampProblem, NamesAClockThatIsAhead) {
  EXPECT_FALSE(stampProblem(-900ms, false));
  EXPECT_THAT(stampProblem(-30s, false).words(), StartsWith("stamps are 30 s ahead: the clocks differ"));
}

TEST(StampProblem, NamesASmallDifferenceOfClocksWhereItIsNoDelay) {
  EXPECT_FALSE(stampProblem(2s, false));
  EXPECT_THAT(stampProblem(2s, true).words(), StartsWith("stamps are 2.0 s old"));
  EXPECT_THAT(stampProblem(-200ms, true).words(), StartsWith("stamps are 0.2 s ahead"));
}

TEST(StampProblem, StaysTheSameWhileSamplesAreLateByTurns) {
  EXPECT_TRUE(stampProblem(600s, false).isSame(stampProblem(720s, false)));
  EXPECT_FALSE(stampProblem(600s, false).isSame(stampProblem(-600s, false)));
}

}  // namespace
}  // namespace slam::freshness_test
