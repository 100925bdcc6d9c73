// SPDX-License-Identifier: BSD-3-Clause
#include "bus/sender_clock.hpp"

#include <gtest/gtest.h>
#include <random>

namespace slam::sender_clock_test {
namespace {

using namespace std::chrono_literals;

/// A sender whose clock is off, over a network that delays: a little always, and sometimes by a tenth of a second.
class Sender : public testing::Test {
 protected:
  /// One message of each period. @return the worst error of the stamps that were taken, behind the first second
  Duration run(SenderClocks::Stream stream, Duration time, Duration behind, Duration lasted = 0ms) {
    Duration worst{0};
    const Timestamp begin = now;
    for (const Timestamp end = now + time; now < end; now += period) {
      const Duration delay = 2ms + (random() % 10 == 0 ? Duration(100ms) : Duration(random() % 3'000'000));
      const Timestamp taken = now - delay - lasted;  // in truth
      const auto mapped = clocks.map(stream, taken - behind, lasted, now);
      if (mapped.refusal != Refusal::kNone) {
        ++refused;
        continue;
      }
      shift = mapped.shift;
      differs = mapped.differs;
      age = mapped.age;
      if (now - begin > 1s) worst = std::max(worst, Duration(std::chrono::abs(taken - behind + mapped.shift - taken)));
    }
    return worst;
  }

  SenderClocks clocks;
  Timestamp now{1000s};
  Duration period = 20ms, shift{0};
  std::mt19937_64 random{1};
  int refused = 0;
  bool differs = false;
  Duration age{0};
};

TEST_F(Sender, WhoseClockIsOursKeepsItsStamps) {
  EXPECT_EQ(run(SenderClocks::kWheels, 60s, 0ms), 0ms);
  EXPECT_EQ(shift, 0ms);
  EXPECT_EQ(refused, 0);
}

TEST_F(Sender, WhoseClockIsOffIsMappedByTheLeastDelay) {
  for (const Duration behind :
       {Duration(2s), Duration(-2s), Duration(24h), Duration(-24h), Duration(700ms), Duration(-100ms)}) {
    clocks.begin(Duration(0));
    refused = 0;
    EXPECT_LT(run(SenderClocks::kWheels, 20s, behind), 12ms) << toSeconds(behind);
    EXPECT_NEAR(toSeconds(shift), toSeconds(behind), 0.012);
    EXPECT_LE(refused, 1) << "the first message may be damaged";
  }
}

TEST_F(Sender, IsNotToBlameForAClockOfOursThatWasSetBack) {
  run(SenderClocks::kWheels, 5s, 0ms);
  clocks.begin(60s);
  refused = 0;
  EXPECT_LE(run(SenderClocks::kWheels, 5s, 60s), 10ms) << "of this computer's clock, as it is now";
  EXPECT_FALSE(differs);
  EXPECT_LE(age, 110ms);
  EXPECT_LE(refused, 2);
  run(SenderClocks::kImu, 5s, 0ms);
  EXPECT_FALSE(differs) << "its clock was not set, ours was";
  EXPECT_LE(age, 110ms);
  run(SenderClocks::kDepth, 5s, 30s);
  EXPECT_TRUE(differs) << "from both";
  clocks.begin(0ms);
  run(SenderClocks::kWheels, 5s, 60s);
  EXPECT_TRUE(differs);
}

TEST_F(Sender, WhoseMicrocontrollerCountsFromItsStartIsMapped) {
  EXPECT_LT(run(SenderClocks::kImu, 20s, Duration(now.time_since_epoch()) + 1'700'000'000s), 12ms);
}

TEST_F(Sender, WhoseClockIsSetIsFollowed) {
  run(SenderClocks::kWheels, 10s, 0ms);
  EXPECT_LT(run(SenderClocks::kWheels, 10s, -24h), 12ms) << "ahead";
  EXPECT_LE(refused, 1);
  refused = 0;
  run(SenderClocks::kWheels, 3s, 60s);
  EXPECT_LE(refused, 55) << "back: for a second they may have been delayed";
  refused = 0;
  EXPECT_LT(run(SenderClocks::kWheels, 10s, 60s), 12ms);
  EXPECT_EQ(refused, 0);
  EXPECT_EQ(run(SenderClocks::kWheels, 20s, 0ms), run(SenderClocks::kWheels, 5s, 0ms)) << "and is right again";
  EXPECT_EQ(shift, 0ms);
}

TEST_F(Sender, HasOneClockForAllItsStreams) {
  for (int i = 0; i < 50; ++i) {
    run(SenderClocks::kWheels, 100ms, 2s);
    const auto scan = clocks.map(SenderClocks::kLidar, now - 190ms - 2s, 180ms, now);
    if (i < 20) continue;
    EXPECT_EQ(scan.refusal, Refusal::kNone);
    EXPECT_NEAR(toSeconds(scan.shift), 2.003, 0.003) << "a scan takes its time on top";
  }
}

TEST_F(Sender, OfOneDamagedStampIsNotFollowed) {
  run(SenderClocks::kWheels, 10s, 0ms);
  EXPECT_EQ(clocks.map(SenderClocks::kWheels, now + 3600s, 0ms, now).refusal, Refusal::kAhead);
  for (const Duration behind : {Duration(3600s), Duration(5100ms)})
    EXPECT_EQ(clocks.map(SenderClocks::kWheels, now - behind, 0ms, now).refusal, Refusal::kOld);
  EXPECT_EQ(clocks.map(SenderClocks::kWheels, now - 4900ms, 0ms, now).refusal, Refusal::kNone) << "it came late";
  EXPECT_EQ(run(SenderClocks::kWheels, 10s, 0ms), 0ms);
}

TEST_F(Sender, OfSpeedsThatWaitedOnTheirWayIsNotTakenForOneOfAnotherClock) {
  for (int i = 0; i < 100; ++i) {  // ten seconds of them, in one burst
    now += 1ms;
    const auto mapped = clocks.map(SenderClocks::kDrive, now - 20s + i * 100ms, 0ms, now);
    EXPECT_NE(mapped.refusal, Refusal::kNone);
  }
  now += 1s;
  refused = 0;
  EXPECT_EQ(run(SenderClocks::kDrive, 5s, 0ms), 0ms);
  EXPECT_EQ(refused, 0);
}

TEST_F(Sender, OfSpeedsOnAnotherClockIsAcceptedAfterASecond) {
  run(SenderClocks::kDrive, 5s, -24h);
  EXPECT_GE(refused, 50);
  EXPECT_LE(refused, 60);
  EXPECT_NEAR(toSeconds(shift), -86400.0, 0.012);
}

TEST_F(Sender, ForgetsTheDelayOfAStreamThatFellSilent) {
  Duration shift_of_wheels{0};
  const auto send = [&](Duration time, bool gyro) {
    for (const Timestamp end = now + time; now < end; now += period) {
      if (gyro) clocks.map(SenderClocks::kImu, now - 2s, 0ms, now);
      shift_of_wheels = clocks.map(SenderClocks::kWheels, now - 2s - 200ms, 0ms, now).shift;
    }
  };
  send(5s, true);
  EXPECT_EQ(shift_of_wheels, 2s) << "the faster stream tells how far off the clock is";
  send(9s, false);
  EXPECT_EQ(shift_of_wheels, 2s);
  send(2s, false);
  EXPECT_EQ(shift_of_wheels, 2200ms) << "it may have been set since";
}

}  // namespace
}  // namespace slam::sender_clock_test
