// SPDX-License-Identifier: BSD-3-Clause
#include "bus/stamp_words.hpp"

#include <gtest/gtest.h>
#include <set>

namespace slam {
namespace {

using namespace std::chrono_literals;

TEST(StampWords, GiveTheAgeOfALogThatIsPlayed) {
  StampWords words;
  EXPECT_STREQ(words.of(0s), "");
  EXPECT_STREQ(words.of(4900ms), "");
  EXPECT_TRUE(std::string(words.of(600s)).starts_with("stamps are 600 s old: use slam-replay"));
  EXPECT_TRUE(std::string(words.of(86'412s)).starts_with("stamps are 86400 s old"));
  EXPECT_STREQ(words.of(100ms), "") << "it is over";
}

TEST(StampWords, NameAClockThatIsAhead) {
  StampWords words;
  EXPECT_STREQ(words.of(-900ms), "");
  EXPECT_TRUE(std::string(words.of(-30s)).starts_with("stamps are 30 s ahead: the clocks differ"));
}

TEST(StampWords, NameASmallDifferenceOfClocksWhereItIsNoDelay) {
  StampWords words;
  EXPECT_STREQ(words.of(2s), "");
  EXPECT_TRUE(std::string(words.of(2s, true)).starts_with("stamps are 2.0 s old"));
  EXPECT_TRUE(std::string(words.of(-200ms, true)).starts_with("stamps are 0.2 s ahead"));
}

TEST(StampWords, StayTheSameWhileSamplesAreLateByTurns) {
  StampWords words;
  const char* const first = words.of(600s);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(words.of(600s + (i % 2 ? 1200ms : -1200ms)), first);
  EXPECT_NE(words.of(620s), first);
}

TEST(StampWords, NeedLittleMemoryForWhateverIsPlayed) {
  StampWords words;
  std::set<const char*> given;
  for (int second = 5; second < 2'000'000; second += 3) given.insert(words.of(std::chrono::seconds(second)));
  EXPECT_LT(given.size(), 4000U);
}

}  // namespace
}  // namespace slam
