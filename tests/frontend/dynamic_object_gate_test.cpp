// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/dynamic_object_gate.hpp"

#include <gtest/gtest.h>
#include <utility>

namespace slam::dynamic_object_gate_test {
namespace {

using namespace std::chrono_literals;

constexpr Timestamp kBegin{100s};
constexpr double kLittle = 0.08;

TEST(DynamicObjectGate, NoisePullsNobody) {
  const DynamicObjectGate watch;
  EXPECT_FALSE(watch.contradicts({0.04, 0.0}, 0.002)) << "the matches' own error";
  EXPECT_FALSE(watch.contradicts({0.12, -0.05}, 0.08)) << "the wheels' own error";
  EXPECT_TRUE(watch.contradicts({0.12, -0.05}, 0.02));
}

TEST(DynamicObjectGate, WhoWalksPullsToAnotherPlaceEachTime) {
  DynamicObjectGate watch;
  for (int i = 0; i < 50; ++i) {
    EXPECT_TRUE(watch.rejects(kBegin + i * 200ms, {0.1 + 0.06 * i, 0.0}, kLittle)) << i;
  }
}

TEST(DynamicObjectGate, WallsPullToTheSamePlaceAndAreAcceptedInTheEnd) {
  DynamicObjectGate watch;
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(watch.rejects(kBegin + i * 200ms, {0.3, 0.005 * i}, kLittle)) << i;
  EXPECT_FALSE(watch.rejects(kBegin + 1s, {0.3, 0.03}, kLittle));
  EXPECT_FALSE(watch.stillRejects(kBegin + 1100ms));
}

TEST(DynamicObjectGate, WhoPulledAMomentAgoIsStillThere) {
  DynamicObjectGate watch;
  EXPECT_FALSE(watch.stillRejects(kBegin));
  EXPECT_TRUE(watch.rejects(kBegin, {0.0, -0.3}, kLittle));
  EXPECT_EQ(watch.direction(), Eigen::Vector2d(0.0, -1.0));
  EXPECT_TRUE(watch.stillRejects(kBegin + 900ms));
  EXPECT_FALSE(watch.stillRejects(kBegin + 1100ms));
}

TEST(DynamicObjectGate, AMatchThatAgreesBeginsThePatienceAnew) {
  DynamicObjectGate watch;
  EXPECT_TRUE(watch.rejects(kBegin, {0.3, 0.0}, kLittle));
  watch.stillRejects(kBegin + 200ms);
  EXPECT_TRUE(watch.rejects(kBegin + 2s, {0.3, 0.0}, kLittle));
  EXPECT_FALSE(watch.rejects(kBegin + 3s, {0.3, 0.0}, kLittle));
}

TEST(DynamicObjectGate, MuchOfAScanIsAcceptedAtOnce) {
  DynamicObjectGate watch;
  EXPECT_FALSE(watch.rejects(kBegin, {0.4, 0.2}, 0.5)) << "the wheels slipped";
  EXPECT_TRUE(watch.rejects(kBegin, {0.4, 0.2}, -0.1)) << "it fits worse there";
  EXPECT_FALSE(watch.rejects(kBegin + 100ms, {0.6, 0.2}, 0.5));
  EXPECT_FALSE(watch.stillRejects(kBegin + 200ms)) << "the wheels were wrong, and nobody pulled";
}

TEST(DynamicObjectGate, EachLimitHoldsFromBothSides) {
  const DynamicObjectGate watch;
  EXPECT_FALSE(watch.contradicts({0.0, 0.049}, 0.0));
  EXPECT_TRUE(watch.contradicts({0.0, -0.051}, 0.0));
  EXPECT_FALSE(watch.contradicts({0.19, 0.0}, 0.1)) << "two standard deviations";
  EXPECT_TRUE(watch.contradicts({0.21, 0.0}, 0.1));
  EXPECT_TRUE(DynamicObjectGate().rejects(kBegin, {0.3, 0.0}, 0.149));
  EXPECT_FALSE(DynamicObjectGate().rejects(kBegin, {0.3, 0.0}, 0.151));
}

TEST(DynamicObjectGate, APlaceIsTheSameWithinAFewCentimetresOfTheFirst) {
  for (const auto& [off, same] : {std::pair(0.039, true), std::pair(0.041, false)}) {
    DynamicObjectGate watch;
    EXPECT_TRUE(watch.rejects(kBegin, {0.3, 0.0}, kLittle));
    EXPECT_EQ(watch.rejects(kBegin + 1s, {0.3, off}, kLittle), !same) << off;
  }
  DynamicObjectGate drifting;  // by little each time, but from the first by more
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(drifting.rejects(kBegin + i * 100ms, {0.3 + 0.01 * i, 0.0}, kLittle)) << i;
}

TEST(DynamicObjectGate, ThePatienceIsThatOfTheConfiguration) {
  for (const double patience : {0.5, 2.0}) {
    DynamicObjectGate watch({.patience = patience});
    EXPECT_TRUE(watch.rejects(kBegin, {0.3, 0.0}, kLittle));
    EXPECT_TRUE(watch.stillRejects(kBegin + fromSeconds(patience - 0.01)));
    EXPECT_FALSE(watch.stillRejects(kBegin + fromSeconds(patience + 0.01)));
    DynamicObjectGate steady({.patience = patience});
    EXPECT_TRUE(steady.rejects(kBegin, {0.3, 0.0}, kLittle));
    EXPECT_TRUE(steady.rejects(kBegin + fromSeconds(patience - 0.01), {0.3, 0.0}, kLittle));
    EXPECT_FALSE(steady.rejects(kBegin + fromSeconds(patience + 0.01), {0.3, 0.0}, kLittle));
  }
}

}  // namespace
}  // namespace slam::dynamic_object_gate_test
