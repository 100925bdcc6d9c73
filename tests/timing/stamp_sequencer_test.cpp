// SPDX-License-Identifier: BSD-3-Clause
#include "timing/stamp_sequencer.hpp"

#include <gtest/gtest.h>
#include <random>
#include <utility>

namespace slam::stamp_sequencer_test {
namespace {

using std::chrono::milliseconds;

Timestamp at(std::int64_t ms) { return Timestamp(milliseconds(ms)); }

/// Feeds stamps of a steady 10 Hz stream. @return stamp of the last [ms]
std::int64_t feedSteady(StampSequencer& sequencer, std::int64_t from_ms, int count) {
  std::int64_t ms = from_ms;
  for (int i = 0; i < count; ++i) sequencer.next(at(ms = from_ms + 100 * i));
  return ms;
}

TEST(StampSequencer, StampsIncreaseWhateverIsRecorded) {
  std::mt19937 random(1);
  std::normal_distribution<double> jitter(0.0, 0.15);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  StampSequencer sequencer;
  Timestamp clock = at(1'000'000), last = Timestamp::min();
  for (int i = 0; i < 20'000; ++i) {
    clock += milliseconds(100);
    if (uniform(random) < 0.002) clock += fromSeconds(2e4 * (uniform(random) - 0.5));  // set, forth or back
    const Timestamp stamp = sequencer.next(clock + fromSeconds(jitter(random)));
    ASSERT_GT(stamp, last) << i;
    last = stamp;
  }
  EXPECT_GT(sequencer.retimed(), 0U);
  EXPECT_GT(sequencer.clockResets(), 0U);
}

TEST(ForwardJumpGuard, LeavesOutAStampAheadOfStreamsThatGoOn) {
  // [ms] Another stream is 5 ms ahead, or has the same stamps and its samples come second.
  for (const auto& [step, others] : {std::pair(140, 5), std::pair(20, -20)}) {
    ForwardJumpGuard guard;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::uint32_t ahead = 0;
    for (int i = 0, bad = 0; i < 5000; ++i) {
      const std::int64_t ms = 1000 + step * i;
      bad = i > 1 && bad < 2 && uniform(random) < 0.03 ? bad + 1 : 0;
      ahead += bad > 0;
      ASSERT_EQ(guard.passes(at(ms + (bad > 0 ? 1000 : 0)), at(ms + others)), bad == 0) << i;
    }
    EXPECT_EQ(guard.held(), ahead);
  }
}

TEST(ForwardJumpGuard, TakesAPauseOfTwoStreamsOfTheSameStamps) {
  ForwardJumpGuard guard;
  for (const std::int64_t ms : {1000, 1140, 2400, 2540})
    EXPECT_TRUE(guard.passes(at(ms), at(ms == 2400 ? 1140 : ms - 140)));
}

TEST(ForwardJumpGuard, TakesAStreamThatIsAlwaysAheadAndAPauseOfAll) {
  ForwardJumpGuard ahead, pause;
  int passed = 0;
  for (int i = 0; i < 100; ++i) passed += ahead.passes(at(1000 + 140 * i + (i > 0 ? 800 : 0)), at(1000 + 140 * i + 5));
  EXPECT_EQ(passed, 100 - 3) << "by another clock";
  for (const std::int64_t ms : {1000, 1140, 3000, 3140}) EXPECT_TRUE(pause.passes(at(ms), at(ms - 5))) << ms;
  EXPECT_TRUE(pause.passes(at(5500), at(3135))) << "the others are silent";
}

TEST(StampSequencer, LeavesAGoodStreamAlone) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> interval(70, 130);
  StampSequencer sequencer;
  std::int64_t ms = 5000;
  for (int i = 0; i < 1000; ++i) {
    ms += interval(random);
    ASSERT_EQ(sequencer.next(at(ms)), at(ms));
  }
  EXPECT_EQ(sequencer.retimed(), 0U);
  EXPECT_EQ(sequencer.clockResets(), 0U);
}

TEST(StampSequencer, MovesACoincidingStampByAQuarterOfTheUsualInterval) {
  StampSequencer sequencer;
  const std::int64_t last = feedSteady(sequencer, 0, 100);
  EXPECT_NEAR(toSeconds(sequencer.next(at(last)) - at(last)), 0.025, 0.003);
  EXPECT_EQ(sequencer.retimed(), 1U);
}

TEST(StampSequencer, CatchesUpAfterAStepBackOfTenthsOfASecond) {
  StampSequencer sequencer;
  const std::int64_t last = feedSteady(sequencer, 0, 100);
  Timestamp previous = at(last);
  for (int i = 1; i <= 20; ++i) {  // the recorder's clock went back by 0.3 s
    const Timestamp recorded = at(last - 300 + 100 * i), stamp = sequencer.next(recorded);
    EXPECT_GT(stamp, previous);
    EXPECT_GE(stamp, recorded);
    if (i > 5) {
      EXPECT_EQ(stamp, recorded) << i;
    }
    previous = stamp;
  }
  EXPECT_GE(sequencer.retimed(), 3U);
  EXPECT_EQ(sequencer.clockResets(), 0U);
}

TEST(StampSequencer, GoesOnWhenTheClockIsSetBackFar) {
  StampSequencer sequencer;
  const Timestamp last = at(feedSteady(sequencer, 10'000'000, 100));
  const Timestamp first = sequencer.next(at(0));
  EXPECT_GT(first, last);
  EXPECT_LT(first, last + milliseconds(500));
  for (int i = 1; i < 100; ++i) EXPECT_EQ(sequencer.next(at(100 * i)), first + milliseconds(100 * i));
  EXPECT_EQ(sequencer.clockResets(), 1U);
}

TEST(StampSequencer, ShiftsAddUpWhenTheClockIsSetBackAgain) {
  StampSequencer sequencer;
  Timestamp last = at(feedSteady(sequencer, 10'000'000, 100));
  for (int set = 1; set <= 3; ++set) {
    for (int i = 0; i < 50; ++i) {
      const Timestamp stamp = sequencer.next(at(1'000'000 - 200'000 * set + 100 * i));
      EXPECT_GT(stamp, last);
      EXPECT_LT(stamp, last + milliseconds(500));
      last = stamp;
    }
    EXPECT_EQ(sequencer.clockResets(), static_cast<std::uint32_t>(set));
  }
}

TEST(StampSequencer, APauseIsNotAnInterval) {
  StampSequencer sequencer;
  const std::int64_t last = feedSteady(sequencer, 0, 100);
  for (int i = 0; i < 50; ++i) {
    const Timestamp recorded = at(last + 60'000 + 100 * i);
    EXPECT_EQ(sequencer.next(recorded), recorded) << i;
  }
  EXPECT_EQ(sequencer.retimed(), 0U);
}

TEST(StampSequencer, APauseAfterTheVeryFirstStampIsSoonForgotten) {
  StampSequencer sequencer;
  sequencer.next(at(0));
  double ahead = 0.0;  // [s] of what was recorded
  for (int i = 0; i < 100; ++i) {
    const Timestamp recorded = at(3000 + 100 * i);
    ahead = toSeconds(sequencer.next(recorded) - recorded);
    ASSERT_LE(ahead, 1.0) << i;
  }
  EXPECT_EQ(ahead, 0.0);
}

TEST(ClockStepBridge, GoesOnFromTheNewestStampWhenTheClockIsSetBack) {
  ClockStepBridge bridge;
  const Timestamp start{std::chrono::hours(10)}, later = start + std::chrono::seconds(60);
  EXPECT_EQ(bridge.next(later, start), later);
  EXPECT_EQ(bridge.next(later - std::chrono::seconds(1), later), later - std::chrono::seconds(1)) << "late, no step";
  const Timestamp newest = later + std::chrono::milliseconds(30);
  EXPECT_EQ(bridge.next(start - std::chrono::hours(2), newest), newest);
  EXPECT_EQ(bridge.next(start - std::chrono::hours(2) + std::chrono::milliseconds(10), newest),
            newest + std::chrono::milliseconds(10));
}

TEST(ForwardJumpGuard, HoldsOneDamagedStampAndLetsTheStreamGoOn) {
  ForwardJumpGuard guard;
  const Timestamp start{std::chrono::seconds(100)};
  for (int i = 0; i < 100; ++i) {
    const Timestamp stamp = start + i * std::chrono::milliseconds(20);
    EXPECT_EQ(guard.passes(i == 50 ? stamp + std::chrono::hours(24) : stamp), i != 50) << i;
  }
  EXPECT_EQ(guard.held(), 1U);
}

TEST(ForwardJumpGuard, LetsAStreamGoOnThatIsSlowerThanAJump) {
  ForwardJumpGuard guard;
  int passed = 0;
  for (int i = 0; i < 100; ++i) passed += guard.passes(Timestamp(std::chrono::seconds(1000 + 4 * i)));
  EXPECT_EQ(passed, 99);
}

TEST(ForwardJumpGuard, AcceptsAPauseOnceASecondSampleConfirmsIt) {
  ForwardJumpGuard guard;
  const Timestamp start{std::chrono::seconds(100)};
  EXPECT_TRUE(guard.passes(start));
  EXPECT_FALSE(guard.passes(start + std::chrono::seconds(60)));
  EXPECT_TRUE(guard.passes(start + std::chrono::seconds(60) + std::chrono::milliseconds(20)));
  EXPECT_TRUE(guard.passes(start + std::chrono::seconds(60) + std::chrono::milliseconds(40)));
}

TEST(StampSequencer, AJumpBackByMoreThanFiveSecondsIsAClockThatWasSet) {
  for (const auto& [back, resets] : {std::pair(4'900, 0U), std::pair(5'100, 1U)}) {
    StampSequencer sequencer;
    const std::int64_t last = feedSteady(sequencer, 100'000, 100);
    const Timestamp stamp = sequencer.next(at(last - back));
    EXPECT_EQ(sequencer.clockResets(), resets) << back;
    EXPECT_NEAR(toSeconds(stamp - at(last)), resets == 0U ? 0.024 : 0.1, 2e-3) << back;
  }
}

TEST(StampSequencer, HasTheUsualInterval) {
  StampSequencer sequencer;
  EXPECT_EQ(sequencer.interval(), 0.0);
  const std::int64_t last = feedSteady(sequencer, 0, 100);
  EXPECT_NEAR(sequencer.interval(), 0.1, 1e-9);
  sequencer.next(at(last + 60'000));  // a pause counts for three intervals at most
  EXPECT_NEAR(sequencer.interval(), 0.1 + 0.05 * 0.2, 1e-9);
}

TEST(StampSequencer, ItsFirstStepsAreEvaluatedByTheShortest) {
  StampSequencer sequencer;
  std::int64_t ms = 0;
  for (const int step : {0, 300, 100, 250, 120}) sequencer.next(at(ms += step));
  EXPECT_NEAR(sequencer.interval(), 0.1, 1e-9);
}

TEST(ClockStepBridge, AStepBackOfMoreThanFiveSecondsIsAClockThatWasSet) {
  for (const auto& [back, set] : {std::pair(4'900, false), std::pair(5'100, true)}) {
    ClockStepBridge bridge;
    bridge.next(at(100'000), at(100'000));
    EXPECT_EQ(bridge.next(at(100'000 - back), at(100'010)), set ? at(100'010) : at(100'000 - back)) << back;
  }
}

TEST(ForwardJumpGuard, AStepForwardByMoreThanThreeSecondsIsHeld) {
  for (const auto& [ahead, passes] : {std::pair(2'950, true), std::pair(3'050, false)}) {
    ForwardJumpGuard guard;
    EXPECT_TRUE(guard.passes(at(100'000)));
    EXPECT_EQ(guard.passes(at(100'000 + ahead)), passes) << ahead;
  }
}

TEST(ForwardJumpGuard, IsConfirmedByASampleThatComesNoEarlierThanThreeSecondsBefore) {
  for (const auto& [next, confirmed] : {std::pair(57'100, true), std::pair(56'900, false)}) {
    ForwardJumpGuard guard;
    EXPECT_TRUE(guard.passes(at(100'000)));
    EXPECT_FALSE(guard.passes(at(160'000)));
    EXPECT_EQ(guard.passes(at(100'000 + next)), confirmed) << next;
  }
}

TEST(ForwardJumpGuard, AStreamAsSlowAsTwiceItsIntervalPasses) {
  for (const auto& [step, passes] : {std::pair(7'900, true), std::pair(8'100, false)}) {
    ForwardJumpGuard guard;
    guard.passes(at(100'000));
    EXPECT_FALSE(guard.passes(at(104'000)));
    EXPECT_TRUE(guard.passes(at(108'000))) << "confirmed: 4 s from sample to sample";
    EXPECT_EQ(guard.passes(at(108'000 + step)), passes) << step;
  }
}

}  // namespace
}  // namespace slam::stamp_sequencer_test
