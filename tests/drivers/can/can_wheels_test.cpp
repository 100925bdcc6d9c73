// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_wheels.hpp"

#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace slam::can_wheels_test {
namespace {

using namespace std::chrono_literals;
using can::odrive::EncoderEstimates;

constexpr Timestamp kStart{1000s};
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::size_t kLeft = 0, kRight = 1;

EncoderEstimates turns(double position, double velocity = 0.0) {
  return {static_cast<float>(position), static_cast<float>(velocity)};
}

/// A wheel that is accelerated and braked [rad, rad/s] at a time [s].
double angleOf(double t) { return 10.0 * t + 5.0 * std::sin(3.0 * t); }
double speedOf(double t) { return 10.0 + 15.0 * std::cos(3.0 * t); }

TEST(CanWheels, BringsBothWheelsToOneInstant) {
  CanWheels wheels({});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> jitter(0.0, 0.002);  // [s]
  std::vector<CanWheels::Pair> pairs;
  for (int i = 0; i < 1000; ++i) {
    for (const std::size_t side : {kLeft, kRight}) {
      const double t = 0.010 * i + 0.004 * static_cast<double>(side) + jitter(random);
      const double factor = side == kLeft ? 1.0 : -0.5;
      const auto pair =
          wheels.add(side, kStart + fromSeconds(t), turns(factor * angleOf(t) / kTurn, factor * speedOf(t) / kTurn));
      if (pair) pairs.push_back(*pair);
    }
  }
  ASSERT_GE(pairs.size(), 999U);
  EXPECT_TRUE(pairs.front().restarted);
  const double t0 = toSeconds(pairs.front().stamp - kStart);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const double t = toSeconds(pairs[i].stamp - kStart);
    ASSERT_GT(pairs[i].stamp, pairs[i - 1].stamp);
    ASSERT_FALSE(pairs[i].restarted);
    const double left = pairs[i].angles[kLeft] - pairs[0].angles[kLeft];
    const double right = pairs[i].angles[kRight] - pairs[0].angles[kRight];
    // Unpaired, the 4 ms between the wheels would be up to 0.1 rad.
    EXPECT_NEAR(left, angleOf(t) - angleOf(t0), 2e-4) << t;
    EXPECT_NEAR(right, -0.5 * (angleOf(t) - angleOf(t0)), 2e-3) << t;
  }
}

TEST(CanWheels, PairAtTheOlderOfTheTwoNewestReadings) {
  CanWheels wheels({});
  for (int i = 0; i < 5; ++i) {
    const Timestamp stamp = kStart + i * 10ms;
    EXPECT_FALSE(wheels.add(kLeft, stamp, turns(0.0)));
    const auto pair = wheels.add(kRight, stamp + 4ms, turns(0.0));
    ASSERT_TRUE(pair);
    EXPECT_EQ(pair->stamp, stamp);
  }
}

TEST(CanWheels, CountForwardAsPositiveThroughSignAndGear) {
  CanWheels wheels({.sign = {1.0, -1.0}, .gear_ratio = 4.0});
  wheels.add(kLeft, kStart, turns(0.0, 20.0));
  const auto first = wheels.add(kRight, kStart, turns(0.0, -20.0));
  wheels.add(kLeft, kStart + 100ms, turns(2.0, 20.0));
  const auto second = wheels.add(kRight, kStart + 100ms, turns(-2.0, -20.0));
  ASSERT_TRUE(first && second);
  EXPECT_NEAR(second->angles[kLeft] - first->angles[kLeft], kTurn / 2.0, 1e-6);
  EXPECT_NEAR(second->angles[kRight] - first->angles[kRight], kTurn / 2.0, 1e-6);
}

TEST(CanWheels, LoseNothingOverALongRunToTheCoarsenessOfSingles) {
  CanWheels wheels({});
  const double start = 20000.0, step = 0.013;  // [turns]; singles are 2e-3 turns apart here
  std::optional<CanWheels::Pair> first, last;
  for (int i = 0; i <= 20000; ++i) {
    const Timestamp stamp = kStart + i * 10ms;
    wheels.add(kLeft, stamp, turns(start + i * step, 1.3));
    last = wheels.add(kRight, stamp, turns(start + i * step, 1.3));
    ASSERT_TRUE(last);
    if (i == 0) first = last;
  }
  EXPECT_NEAR(last->angles[kLeft] - first->angles[kLeft], 20000 * step * kTurn, 0.002 * kTurn);
}

/// Feeds both wheels at 100 Hz with a right wheel that stands at `right` [turns].
struct Feed {
  CanWheels wheels{{}};
  Timestamp stamp = kStart;
  std::optional<CanWheels::Pair> step(const EncoderEstimates& right) {
    stamp += 10ms;
    wheels.add(kLeft, stamp, turns(1.0));
    return wheels.add(kRight, stamp, right);
  }
  /// Until estimates of the right wheel are believed again. @return the first pair
  std::optional<CanWheels::Pair> untilBelieved(const EncoderEstimates& right) {
    std::optional<CanWheels::Pair> pair;
    for (int i = 0; i < 12 && !pair; ++i) pair = step(right);
    return pair;
  }
};

TEST(CanWheels, LeaveOutASingleDamagedEstimate) {
  Feed feed;
  const auto before = feed.step(turns(5.0));
  EXPECT_FALSE(feed.step(turns(4000.0)));
  EXPECT_FALSE(feed.step(turns(5.0, 1e9)));
  EXPECT_EQ(feed.wheels.rejects(), 2);
  const auto after = feed.untilBelieved(turns(5.01));
  ASSERT_TRUE(before && after);
  EXPECT_FALSE(after->restarted);
  EXPECT_NEAR(after->angles[kRight] - before->angles[kRight], 0.01 * kTurn, 1e-4);
}

TEST(CanWheels, MarkADriveThatCountsAnew) {
  Feed feed;
  feed.step(turns(50.0));
  const auto before = feed.step(turns(50.0));
  EXPECT_FALSE(feed.step(turns(0.0)));
  const auto anew = feed.untilBelieved(turns(0.01));
  ASSERT_TRUE(before && anew);
  EXPECT_TRUE(anew->restarted);
  EXPECT_NEAR(anew->angles[kRight], before->angles[kRight], 1e-9) << "the jump is no motion";
  const auto after = feed.step(turns(0.02));
  ASSERT_TRUE(after);
  EXPECT_FALSE(after->restarted);
}

TEST(CanWheels, MarkWhatComesAfterASilence) {
  Feed feed;
  feed.step(turns(0.1));
  feed.stamp += 2s;
  EXPECT_FALSE(feed.step(turns(0.0))) << "one estimate alone may be damaged";
  const auto after = feed.untilBelieved(turns(0.0));
  ASSERT_TRUE(after);
  EXPECT_TRUE(after->restarted) << "a drive that was reset near its start would be taken for one that turned";
}

TEST(CanWheels, MakeNoPairWithASilentWheel) {
  Feed feed;
  feed.step(turns(0.0));
  for (int i = 0; i < 100; ++i) {
    feed.stamp += 10ms;
    EXPECT_FALSE(feed.wheels.add(kLeft, feed.stamp, turns(1.0)));
  }
  const auto late = feed.wheels.add(kRight, feed.stamp - 900ms, turns(0.0));
  EXPECT_FALSE(late) << "too far apart";
}

TEST(CanWheels, LeaveOutEstimatesThatComeInTheWrongOrder) {
  Feed feed;
  feed.step(turns(1.0, 10.0));
  const auto before = feed.step(turns(1.1, 10.0));
  feed.wheels.add(kLeft, feed.stamp + 1ms, turns(1.0));
  EXPECT_FALSE(feed.wheels.add(kRight, feed.stamp - 1ms, turns(1.05, 10.0)));
  EXPECT_EQ(feed.wheels.rejects(), 1);
  const auto after = feed.wheels.add(kRight, feed.stamp + 1ms, turns(1.1, 10.0));
  ASSERT_TRUE(before && after);
  EXPECT_NEAR(after->angles[kRight], before->angles[kRight], 1e-9);
}

TEST(CanWheels, SurviveRandomEstimatesAndGoOn) {
  Feed feed;
  std::mt19937 random(11);
  int believed = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto pair = feed.step({std::bit_cast<float>(static_cast<std::uint32_t>(random()) & 0x7F7FFFFFU),
                                 std::bit_cast<float>(static_cast<std::uint32_t>(random()) & 0x7F7FFFFFU)});
    if (pair) ++believed;
    ASSERT_TRUE(!pair || std::isfinite(pair->angles[kRight]));
  }
  EXPECT_LE(believed, 3) << "a third of them look like a wheel that stands";
  EXPECT_GT(feed.wheels.rejects(), 19000);
  feed.untilBelieved(turns(7.0));
  const auto pair = feed.step(turns(7.0));
  ASSERT_TRUE(pair);
  EXPECT_FALSE(pair->restarted);
}

TEST(CanWheels, GoOnWhereTheyAreSpedUpBetweenTwoEstimates) {
  CanWheels wheels({});
  for (int i = 0; i < 20; ++i) {
    const double t = 0.35 * (i - 10), speed = t > 0.0 ? 7.0 : 0.0;        // [rad/s] 20 rad/s^2 for a period
    const double angle = t > 0.0 ? speed * t - 0.5 * speed * 0.35 : 0.0;  // [rad]
    for (const std::size_t side : {kLeft, kRight}) {
      const auto pair = wheels.add(side, kStart + i * 350ms, turns(angle / kTurn, speed / kTurn));
      EXPECT_EQ(pair && pair->restarted, i == 0 && side == kRight);
    }
  }
  EXPECT_EQ(wheels.rejects(), 0);
}

TEST(CanWheels, PairAtAnyPeriodThatDrivesSendAt) {
  struct Case {
    Duration left, right;
  };
  for (const Case& rate : {Case{100ms, 100ms},
                           {200ms, 200ms},
                           {250ms, 250ms},
                           {450ms, 450ms},
                           {1000ms, 1000ms},
                           {10ms, 200ms},
                           {300ms, 100ms}}) {
    SCOPED_TRACE(std::to_string(rate.left / 1ms) + ", " + std::to_string(rate.right / 1ms));
    CanWheels wheels({});
    std::mt19937 random(7);
    std::uniform_real_distribution<double> jitter(0.0, 0.003);  // [s]
    const std::array<Duration, 2> periods{rate.left, rate.right};
    // The right one is half a period behind: the worst for pairs.
    std::array<Timestamp, 2> next{kStart, kStart + rate.right / 2};
    std::vector<CanWheels::Pair> pairs;
    while (next[0] < kStart + 20s) {
      const std::size_t side = next[1] < next[0] ? kRight : kLeft;
      const double t = toSeconds(next[side] - kStart) + jitter(random);
      const double angle = 3.0 * t + std::sin(t), speed = 3.0 + std::cos(t);
      if (const auto pair = wheels.add(side, kStart + fromSeconds(t), turns(angle / kTurn, speed / kTurn)))
        pairs.push_back(*pair);
      next[side] += periods[side];
    }
    const auto expected = static_cast<std::size_t>(20s / std::max(rate.left, rate.right));
    const bool seldom = rate.left > 500ms;  // then it takes ten to believe the first one
    EXPECT_GE(pairs.size() + (seldom ? 12 : 3), expected);
    EXPECT_LE(wheels.rejects(), seldom ? 20 : 0);
    ASSERT_FALSE(pairs.empty());
    const double t0 = toSeconds(pairs.front().stamp - kStart);
    for (std::size_t i = 1; i < pairs.size(); ++i) {
      const double t = toSeconds(pairs[i].stamp - kStart);
      ASSERT_FALSE(pairs[i].restarted) << t;
      for (const double angle : {pairs[i].angles[0] - pairs[0].angles[0], pairs[i].angles[1] - pairs[0].angles[1]})
        ASSERT_NEAR(angle, 3.0 * (t - t0) + std::sin(t) - std::sin(t0), seldom ? 0.3 : 0.03) << t;
    }
  }
}

TEST(CanWheel, LearnsItsPeriodInSpiteOfLossesAndEstimatesThatComeAtOnce) {
  CanWheel wheel(kTurn, 100.0);
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    if (random() % 10 != 0) wheel.add(kStart + i * 200ms + (random() % 20) * 1ms, turns(0.0));
    if (i > 20) {
      EXPECT_GE(wheel.period(), 170ms);
      EXPECT_LE(wheel.period(), 450ms);
    }
  }
}

TEST(CanWheel, RefusesASpeedThatNoWheelHas) {
  using Outcome = CanWheel::Outcome;
  const Timestamp now{std::chrono::seconds(1)};
  for (const float sign : {1.0F, -1.0F}) {
    EXPECT_EQ(CanWheel(6.2832, 100.0).add(now, {0.0F, sign * 15.5F}), Outcome::kGoodAnew);  // 97 rad/s
    EXPECT_EQ(CanWheel(6.2832, 100.0).add(now, {0.0F, sign * 16.5F}), Outcome::kRejected);  // 104 rad/s
  }
}

}  // namespace
}  // namespace slam::can_wheels_test
