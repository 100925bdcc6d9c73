// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/wheel_scale.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <utility>

namespace slam::wheel_scale_test {
namespace {

constexpr double kStretch = 0.06;  // [m]

/// Stretches of a way that wheels and scans tell, each with its own errors.
class Way {
 public:
  explicit Way(unsigned seed) : random_(seed) {}

  /// @param truth the wheels' way beside the real one  @param noise of the wheels [m per sqrt(m)]
  void go(double metres, double truth, double noise, double scan_sigma = 0.003) {
    const double sigma = noise * std::sqrt(kStretch), variance = sigma * sigma + 2.0 * scan_sigma * scan_sigma;
    for (double way = 0.0; way < metres; way += kStretch) {
      const Pose2 wheels{truth * kStretch + sigma * normal_(random_), 0.0, 0.0};
      const double bearing = 0.05 * std::sin(way);
      const double seen = kStretch + scan_sigma * normal_(random_);
      scale.add(wheels, {seen * std::cos(bearing), seen * std::sin(bearing), 0.0}, variance, 1.0);
    }
  }
  /// The wheels spin, or their counters jump.
  void slip(double metres) { scale.add({kStretch + metres, 0.0, 0.0}, {kStretch, 0.0, 0.0}, 1e-4, 1.0); }

  WheelScale scale;

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

TEST(WheelScale, IsFoundWithinItsStandardDeviation) {
  double squared = 0.0;
  int count = 0;
  for (const double truth : {0.7, 0.9, 0.97, 1.0, 1.05, 1.2, 1.5}) {
    for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) {
      Way way(seed);
      way.go(30.0, truth, 0.05);
      EXPECT_LT(way.scale.sigma(), 0.015);
      squared += std::pow((way.scale.value() - truth) / way.scale.sigma(), 2);
      ++count;
    }
  }
  EXPECT_LT(squared / count, 2.0) << "a value of 1 that is not yet known better counts, too";
}

TEST(WheelScale, NoisyWheelsDoNotLookShort) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Way way(seed);
    way.go(400.0, 1.0, 0.3);  // a stretch's noise is larger than the stretch
    EXPECT_NEAR(way.scale.value(), 1.0, 0.06) << seed;
  }
}

TEST(WheelScale, IsNotUsedBeforeItIsKnown) {
  Way way(1);
  EXPECT_EQ(way.scale.value(), 1.0);
  way.go(0.5, 1.05, 0.1);
  EXPECT_EQ(way.scale.value(), 1.0);
  way.go(60.0, 1.05, 0.1);
  EXPECT_NEAR(way.scale.value(), 1.05, 0.03);
}

TEST(WheelScale, SlipAndJumpsDoNotMoveIt) {
  Way way(1);
  way.go(10.0, 1.1, 0.05);
  const double before = way.scale.value();
  for (const double metres : {0.3, 0.5, -0.4, 2.0}) way.slip(metres);
  EXPECT_EQ(way.scale.value(), before);
}

TEST(WheelScale, FollowsALoadThatFlattensTheTyres) {
  Way way(1);
  way.go(300.0, 1.0, 0.05);
  way.go(300.0, 1.04, 0.05);
  EXPECT_NEAR(way.scale.value(), 1.04, 0.015);
}

TEST(WheelScale, WheelsThatStandOrRunBackwardsAreAFaultAndNoScale) {
  for (const double truth : {0.0, 0.1, -1.0, 4.0}) {
    Way way(1);
    way.go(100.0, truth, 0.05);
    EXPECT_EQ(way.scale.value(), 1.0) << truth;
  }
}

TEST(WheelScale, StretchesWithoutInformationAreLeftOut) {
  WheelScale scale;
  const Pose2 seen{0.05, 0.0, 0.0};
  scale.add(seen, {}, 1e-4, 1.0);
  scale.add({NAN, 0.0, 0.0}, seen, 1e-4, 1.0);
  scale.add(seen, {NAN, 0.0, 0.0}, 1e-4, 1.0);
  scale.add(seen, seen, NAN, 1.0);
  scale.add(seen, seen, 0.0, 1.0);
  scale.add(seen, seen, 1e-4, 0.0);
  EXPECT_EQ(scale.value(), 1.0);
  EXPECT_NEAR(scale.sigma(), WheelScaleConfig{}.initial_sigma, 1e-4);
}

TEST(RescaledWheels, AWayOfAnyShapeKeepsItsShape) {
  Way way(1);
  way.go(60.0, 1.25, 0.02);
  const double c = way.scale.value();
  ASSERT_NEAR(c, 1.25, 0.01);
  RescaledWheels rescaled;
  const Pose2 begin{3.0, -1.0, 2.0};
  Pose2 told = begin;
  EXPECT_EQ(rescaled.add(told, way.scale).vector(), begin.vector());
  for (int i = 0; i < 200; ++i) {
    told = told * Pose2{0.05, 0.01 * std::sin(i), 0.03};
    const Pose2 right = rescaled.add(told, way.scale);
    const Pose2 moved = between(begin, told), corrected = between(begin, right);
    EXPECT_NEAR(corrected.x, moved.x / c, 1e-9);
    EXPECT_NEAR(corrected.y, moved.y / c, 1e-9);
    EXPECT_NEAR(wrapAngle(corrected.theta - moved.theta), 0.0, 1e-9);
  }
}

TEST(WheelScale, OneStretchIsKalmansUpdate) {
  for (const double turn : {0.0, 0.8}) {
    for (const double sigma : {0.2, 0.05}) {
      WheelScale scale({.initial_sigma = sigma, .noise = 0.01, .significance = 0.0});
      // The wheels tell 1.1 m where the scans tell 1 m, along the scans' direction.
      const Pose2 scans{std::cos(turn), std::sin(turn), 0.0};
      scale.add({1.1 * std::cos(turn), 1.1 * std::sin(turn), 0.0}, scans, 0.02, 1.5);
      const double prior = sigma * sigma + 0.01 * 0.01, K = prior / (prior + 1.5 * 0.02);
      EXPECT_NEAR(scale.value(), 1.0 + K * 0.1, 1e-12);
      EXPECT_NEAR(scale.sigma(), std::sqrt((1.0 - K) * prior), 1e-12);
    }
  }
}

TEST(WheelScale, TakesTheWheelsWayAlongTheScansDirectionAlone) {
  WheelScale along, across;
  along.add({1.1, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.01, 1.0);
  across.add({1.1, 0.3, 0.0}, {1.0, 0.0, 0.0}, 0.01, 1.0);
  EXPECT_EQ(along.sigma(), across.sigma());
  EXPECT_EQ(along.value(), across.value());
}

TEST(WheelScale, EachLimitHoldsFromBothSides) {
  // The gate: three standard deviations of prior and noise, sqrt(0.04 + 0.01) m together.
  for (const auto& [off, taken] :
       {std::pair(0.66, true), std::pair(0.68, false), std::pair(-0.66, true), std::pair(-0.68, false)}) {
    WheelScale scale({.noise = 0.0});
    scale.add({1.0 + off, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.01, 1.0);
    EXPECT_EQ(scale.sigma() < 0.19, taken) << off;
  }
  // Significance: 0.1 off at a standard deviation of 0.2 sqrt(0.01 / 0.05) = 0.0894.
  for (const auto& [significance, believed] : {std::pair(0.85, true), std::pair(0.95, false)}) {
    WheelScale scale({.noise = 0.0, .significance = significance});
    scale.add({1.1, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.01, 1.0);
    EXPECT_EQ(scale.value() != 1.0, believed) << significance;
  }
  for (const auto& [truth, believed] :
       {std::pair(1.95, true), std::pair(2.05, false), std::pair(0.52, true), std::pair(0.48, false)}) {
    WheelScale scale({.initial_sigma = 5.0, .noise = 0.0});
    for (int i = 0; i < 1000; ++i) scale.add({truth, 0.0, 0.0}, {1.0, 0.0, 0.0}, 1e-3, 1.0);
    EXPECT_EQ(scale.value() != 1.0, believed) << truth << " is a fault and no scale";
  }
}

TEST(WheelScale, CorrectsTheWayAndNotTheTurn) {
  WheelScale scale({.initial_sigma = 5.0, .noise = 0.0});
  for (int i = 0; i < 1000; ++i) scale.add({1.25, 0.0, 0.0}, {1.0, 0.0, 0.0}, 1e-3, 1.0);
  const Pose2 corrected = scale.corrected({2.5, -1.25, 0.4});
  EXPECT_NEAR(corrected.x, 2.0, 1e-4);
  EXPECT_NEAR(corrected.y, -1.0, 1e-4);
  EXPECT_EQ(corrected.theta, 0.4);
}

}  // namespace
}  // namespace slam::wheel_scale_test
