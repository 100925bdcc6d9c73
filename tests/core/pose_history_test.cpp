// SPDX-License-Identifier: BSD-3-Clause
#include "core/pose_history.hpp"

#include <gtest/gtest.h>
#include <random>

#include "support/allocations.hpp"

namespace slam::pose_history_test {
namespace {

using std::chrono::milliseconds;

Timestamp at(int ms) { return Timestamp(milliseconds(ms)); }

void expectSame(const Pose2& actual, const Pose2& expected, double tolerance = 1e-9) {
  EXPECT_NEAR(actual.x, expected.x, tolerance);
  EXPECT_NEAR(actual.y, expected.y, tolerance);
  EXPECT_NEAR(wrapAngle(actual.theta - expected.theta), 0.0, tolerance);
}

/// Pose at `ms` on an arc of constant twist that begins at an arbitrary place.
Pose2 onArc(int ms) { return Pose2{3, -2, 3.0} * exp(Eigen::Vector3d{0.5, 0.1, 1.2} * ms * 1e-3); }

PoseHistory arc(int first_ms, int last_ms, int step_ms, std::size_t capacity = 100) {
  PoseHistory history(capacity);
  for (int ms = first_ms; ms <= last_ms; ms += step_ms) history.push(at(ms), onArc(ms));
  return history;
}

TEST(Interpolate, StaysOnTheArcOfConstantTwist) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> metres(-2, 2), radians(-3, 3), share(-0.5, 1.5);
  for (int i = 0; i < 200; ++i) {
    const Pose2 from{metres(random), metres(random), radians(random)};
    const Eigen::Vector3d xi{metres(random), metres(random), radians(random)};
    const double fraction = share(random);
    expectSame(interpolate(from, from * exp(xi), fraction), from * exp(fraction * xi));
    expectSame(interpolate(from, from * exp(xi), 0.0), from);
    expectSame(interpolate(from, from * exp(xi), 1.0), from * exp(xi));
  }
}

TEST(Interpolate, TurnsTheShortWayAcrossTheHalfTurn) {
  const Pose2 middle = interpolate({0, 0, 3.1}, {0, 0, -3.1}, 0.5);
  EXPECT_NEAR(std::abs(middle.theta), std::numbers::pi, 1e-9);
}

TEST(PoseHistory, InterpolatesBetweenTheNeighboursOfTheStamp) {
  const PoseHistory history = arc(0, 1000, 100);
  for (int ms = 0; ms <= 1000; ms += 7) {
    const auto pose = history.at(at(ms));
    ASSERT_TRUE(pose) << ms;
    expectSame(*pose, onArc(ms));
  }
}

TEST(PoseHistory, ExtrapolatesBeyondBothEndsAsFarAsAllowed) {
  const PoseHistory history = arc(0, 1000, 100);
  for (const int ms : {-49, -1, 1001, 1049}) {
    EXPECT_FALSE(history.at(at(ms)));
    const auto pose = history.at(at(ms), milliseconds(50));
    ASSERT_TRUE(pose) << ms;
    expectSame(*pose, onArc(ms));
  }
  EXPECT_FALSE(history.at(at(-51), milliseconds(50)));
  EXPECT_FALSE(history.at(at(1051), milliseconds(50)));
}

TEST(PoseHistory, ForgetsTheOldestWhenFull) {
  const PoseHistory history = arc(0, 1000, 10, 8);
  ASSERT_EQ(history.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(history[i].stamp, at(930 + 10 * static_cast<int>(i)));
    EXPECT_EQ(history[i].pose, onArc(930 + 10 * static_cast<int>(i)));
  }
  EXPECT_EQ(history.newest().stamp, at(1000));
  EXPECT_FALSE(history.at(at(925)));
  expectSame(history.at(at(935)).value(), onArc(935));
}

TEST(PoseHistory, RefusesAnEarlierStampAndReplacesAnEqualOne) {
  PoseHistory history = arc(0, 100, 50);
  EXPECT_FALSE(history.push(at(99), {9, 9, 0}));
  EXPECT_EQ(history.size(), 3U);
  EXPECT_EQ(history.newest().pose, onArc(100));

  EXPECT_TRUE(history.push(at(100), {9, 9, 0}));
  EXPECT_EQ(history.size(), 3U);
  EXPECT_EQ(history.newest().pose, (Pose2{9, 9, 0}));
}

TEST(PoseHistory, WithoutAPairHasTheInstantOfItsOnlyPose) {
  PoseHistory history(4);
  EXPECT_TRUE(history.empty());
  EXPECT_FALSE(history.at(at(0), milliseconds(1000)));
  history.push(at(5), {1, 2, 3});
  EXPECT_EQ(history.at(at(5)), (Pose2{1, 2, 3}));
  EXPECT_FALSE(history.at(at(6)));
}

TEST(PoseHistory, StartsAgainAfterClear) {
  PoseHistory history = arc(0, 1000, 10, 8);
  history.clear();
  EXPECT_TRUE(history.empty());
  EXPECT_TRUE(history.push(at(1), {1, 0, 0}));  // earlier than what was forgotten
  EXPECT_EQ(history.newest().pose, (Pose2{1, 0, 0}));
}

TEST(PoseHistory, DoesNotAllocateAfterConstruction) {
  PoseHistory history(16);
  EXPECT_EQ(test::allocationsDuring([&] {
              for (int ms = 0; ms < 1000; ++ms) history.push(at(ms), onArc(ms));
              history.at(at(990));
              history.clear();
              history.push(at(0), {});
            }),
            0U);
}

}  // namespace
}  // namespace slam::pose_history_test
