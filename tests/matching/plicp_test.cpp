// SPDX-License-Identifier: BSD-3-Clause
#include "matching/plicp.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <gtest/gtest.h>

#include "matching/scanning.hpp"
#include "support/allocations.hpp"

namespace slam::plicp_test {
namespace {

using test::Room;
using test::scanPoints;

constexpr Pose2 kReferencePose{0.4, -0.3, 0.1};  // off every symmetry of the room

MatchConfig noisy(double sigma) {
  MatchConfig config;
  config.range_sigma = sigma;
  return config;
}

// The first matcher test to write: along a featureless corridor a matcher must not claim what it cannot see.
class NoisyCorridor : public testing::TestWithParam<double> {};

TEST_P(NoisyCorridor, IsBlindAlongItsWalls) {
  const Room corridor{.length = 1e6, .width = 2.0, .reach = 8.0, .range_sigma = GetParam()};
  std::mt19937 random(1);
  int silent = 0;
  for (int trial = 0; trial < 50; ++trial) {
    Reference reference;
    reference.add(Pose2{}, scanPoints(corridor, Pose2{}, random));
    const Pose2 truth{0.05, 0.02, 0.03}, guess{0.0, 0.0, 0.0};
    const MatchResult result =
        matchPointToLine(reference, scanPoints(corridor, truth, random), guess, noisy(GetParam()));
    if (result.status == MatchStatus::kConverged) continue;
    ++silent;
    ASSERT_EQ(result.status, MatchStatus::kUnobservable);
    ASSERT_EQ(result.observable, 2);
    EXPECT_GT(std::abs(result.directions(0, 2)), 0.99);  // blind along x
    EXPECT_NEAR(result.T_ref_base.x, guess.x, 0.01);     // where it is blind it stays with the guess
    EXPECT_NEAR(result.T_ref_base.y, truth.y, 0.01);     // and what it can see it finds
    EXPECT_NEAR(result.T_ref_base.theta, truth.theta, 0.005);
  }
  EXPECT_GE(silent, 49);
}

INSTANTIATE_TEST_SUITE_P(RangeNoise, NoisyCorridor, testing::Values(0.0, 0.005, 0.010, 0.015));

TEST(PlIcp, APointThatMaySlideGivesTheWayOnceItWasMetOften) {
  std::mt19937 random(5);
  const Room corridor{.length = 1e6, .width = 2.0, .reach = 4.0, .range_sigma = 0.005};
  const Pose2 truth{0.04, 0.01, 0.0};
  for (const int times : {1, 3, 10}) {
    Reference reference;
    ScanPoints seen = scanPoints(corridor, Pose2{}, random), now = scanPoints(corridor, truth, random), spots;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector2d spot(5.0 + i, i % 2 ? 1.0 : -1.0);
      spots.push_back({.position = spot, .range = spot.norm(), .grazing = true});
      now.push_back({.position = truth.inverse() * spot, .range = spot.norm(), .grazing = true});
    }
    reference.add(Pose2{}, seen);
    for (int i = 0; i < times; ++i) reference.add(Pose2{}, spots);
    const MatchResult result = matchPointToLine(reference, now, Pose2{}, noisy(0.005));
    ASSERT_TRUE(result.usable());
    EXPECT_EQ(result.observable, times < 8 ? 2 : 3) << times;
    EXPECT_NEAR(result.T_ref_base.x, times < 8 ? 0.0 : truth.x, 0.01) << times;
    EXPECT_NEAR(result.T_ref_base.y, truth.y, 0.005) << times;
  }
}

TEST(PlIcp, ClaimsNoMoreCertaintyThanItHas) {
  const double sigma = 0.01;
  const Room room{.range_sigma = sigma};
  std::mt19937 random(2);
  double nees = 0.0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    Reference reference;
    reference.add(Pose2{}, scanPoints(room, kReferencePose, random));
    const Pose2 motion{0.08, 0.05, -0.08};
    const MatchResult result =
        matchPointToLine(reference, scanPoints(room, kReferencePose * motion, random), {}, noisy(sigma));
    ASSERT_EQ(result.status, MatchStatus::kConverged);
    Eigen::Vector3d error = result.T_ref_base.vector() - motion.vector();
    nees += error.dot(result.covariance.llt().solve(error)) / kTrials;
  }
  // 3 for a perfect covariance. The reference is one noisy scan here, which the covariance does not see: it may
  // claim up to twice the certainty in variance, no more.
  EXPECT_LT(nees, 6.0);
  EXPECT_GT(nees, 0.3);
}

class PlIcpMotion : public testing::TestWithParam<Pose2> {};

TEST_P(PlIcpMotion, IsRecoveredUnderNoiseFromAnIdentityGuess) {
  const Room room{.range_sigma = 0.01};
  std::mt19937 random(3);
  Reference reference;
  reference.add(Pose2{}, scanPoints(room, kReferencePose, random));
  const Pose2 motion = GetParam();
  const MatchResult result =
      matchPointToLine(reference, scanPoints(room, kReferencePose * motion, random), {}, noisy(0.01));
  ASSERT_EQ(result.status, MatchStatus::kConverged);
  const Pose2 error = between(motion, result.T_ref_base);
  EXPECT_LT(std::hypot(error.x, error.y), 0.006);
  EXPECT_LT(std::abs(error.theta), 0.003);
  EXPECT_GT(result.overlap, 0.9);
}

INSTANTIATE_TEST_SUITE_P(BetweenTwoScans, PlIcpMotion,
                         testing::Values(Pose2{}, Pose2{0.10, 0, 0}, Pose2{0, -0.10, 0}, Pose2{0, 0, 0.10},
                                         Pose2{0.3, 0.2, -0.2}, Pose2{-0.2, 0.1, 0.4}));

TEST(PlIcp, SwappingTheScansInvertsTheMotion) {
  const Room room{.range_sigma = 0.005};
  std::mt19937 random(4);
  const auto a = scanPoints(room, kReferencePose, random);
  const auto b = scanPoints(room, kReferencePose * Pose2{0.08, 0.05, -0.08}, random);
  Reference reference_a, reference_b;
  reference_a.add(Pose2{}, a);
  reference_b.add(Pose2{}, b);
  const Pose2 forth = matchPointToLine(reference_a, b, {}).T_ref_base;
  const Pose2 back = matchPointToLine(reference_b, a, {}).T_ref_base;
  const Pose2 error = forth * back;
  EXPECT_LT(std::hypot(error.x, error.y), 0.006);
  EXPECT_LT(std::abs(error.theta), 0.004);
}

TEST(PlIcp, APointBeyondTheReferencesWindowContradictsNothing) {
  // In the corner of a hall, half of the walls are further off than the window reaches.
  const Room hall{.length = 60.0, .width = 50.0, .reach = 80.0, .range_sigma = 0.01};
  const Pose2 corner{-27.0, -22.0, 0.3}, motion{0.05, -0.04, 0.02};
  std::mt19937 random(8);
  Reference reference({.extent = 25.6});
  const auto seen = scanPoints(hall, corner, random);
  const int inside = static_cast<int>(std::count_if(
      seen.begin(), seen.end(), [&](const ScanPoint& point) { return reference.covers(point.position); }));
  ASSERT_GT(inside, 60);
  ASSERT_LT(inside, static_cast<int>(seen.size()) * 7 / 10);
  for (int i = 0; i < 5; ++i) reference.add(Pose2{}, scanPoints(hall, corner, random));
  const MatchResult result = matchPointToLine(reference, scanPoints(hall, corner * motion, random), {}, noisy(0.01));
  EXPECT_EQ(result.status, MatchStatus::kConverged) << result.observable << " " << result.pairs;
  EXPECT_GT(result.overlap, 0.85);
  EXPECT_GT(result.known_ratio, 0.7);
  EXPECT_NEAR(result.T_ref_base.x, motion.x, 0.02);
  EXPECT_NEAR(result.T_ref_base.y, motion.y, 0.02);
}

TEST(PlIcp, GivesByHowMuchTheScansPartsContradictEachOther) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937 random(seed);
    const Room room{.length = 6.0, .width = 4.0, .reach = 8.0, .range_sigma = 0.005};
    Reference reference;
    reference.add(Pose2{}, scanPoints(room, Pose2{}, random));
    const auto match = [&](double moved, const MatchConfig& config) {
      ScanPoints points = scanPoints(room, Pose2{}, random);
      for (ScanPoint& point : points) {  // of one end wall, its left half
        if (point.position.x() > 2.9 && point.position.y() > 0.0) point.position.x() += moved;
      }
      return matchPointToLine(reference, points, Pose2{}, config);
    };
    const MatchResult sound = match(0.0, noisy(0.005)), moved = match(0.1, noisy(0.005));
    ASSERT_TRUE(sound.usable() && moved.usable());
    const auto sigma = [](const Eigen::Matrix3d& covariance, int i) { return std::sqrt(covariance(i, i)); };
    const auto noise = [&](const MatchResult& result) { return sigma(result.covariance - result.tension, 0); };
    EXPECT_LT(sigma(sound.tension, 0), 1.5 * noise(sound)) << seed;
    EXPECT_GT(sigma(moved.tension, 0), 3.0 * noise(moved)) << seed;
    EXPECT_GT(3.0 * sigma(moved.covariance, 0), std::abs(moved.T_ref_base.x)) << seed;
    EXPECT_GT(3.0 * sigma(moved.tension, 0), std::abs(moved.T_ref_base.x)) << seed;
    EXPECT_LT(sigma(moved.tension, 1), 0.5 * sigma(moved.tension, 0)) << seed << ", across nothing contradicts";
    MatchConfig whole = noisy(0.005);
    whole.part_gap = 1e9, whole.part_bend = -2.0;
    EXPECT_LT(sigma(match(0.1, whole).tension, 0), 0.1 * sigma(moved.tension, 0)) << "one part agrees with itself";
  }
}

TEST(PlIcp, RefusesAnotherRoom) {
  std::mt19937 random(5);
  Reference reference;
  reference.add(Pose2{}, scanPoints(Room{.length = 12.0, .width = 9.0, .range_sigma = 0.01}, Pose2{}, random));
  const MatchResult result = matchPointToLine(
      reference, scanPoints(Room{.length = 5.0, .width = 3.0, .range_sigma = 0.01}, {0.3, 0.2, 0.4}, random), {});
  EXPECT_FALSE(result.usable());
}

TEST(PlIcp, RefusesAScanWithTooFewPairs) {
  std::mt19937 random(6);
  Reference reference;
  const auto points = scanPoints(Room{}, kReferencePose, random);
  reference.add(Pose2{}, points);
  EXPECT_EQ(matchPointToLine(reference, points, {40.0, 0, 0}).status, MatchStatus::kTooFewPairs);
  EXPECT_EQ(matchPointToLine(reference, {}, {}).status, MatchStatus::kTooFewPairs);
  EXPECT_EQ(matchPointToLine(Reference{}, points, {}).status, MatchStatus::kTooFewPairs);
}

TEST(PlIcp, DoesNotAllocate) {
  std::mt19937 random(7);
  Reference reference;
  const auto points = scanPoints(Room{.range_sigma = 0.01}, kReferencePose, random);
  reference.add(Pose2{}, points);
  EXPECT_EQ(test::allocationsDuring([&] { matchPointToLine(reference, points, {0.05, 0.02, 0.01}); }), 0U);
}

TEST(PlIcp, AScanAgreesWhereItWasTakenAndNotBesideIt) {
  const Room room{.range_sigma = 0.005};
  std::mt19937 random(5);
  Reference reference;
  for (int i = 0; i < 3; ++i) reference.add(kReferencePose, scanPoints(room, kReferencePose, random));
  const auto points = scanPoints(room, kReferencePose, random);
  const double there = overlapAt(reference, points, kReferencePose, 0.05);
  EXPECT_GT(there, 0.97);
  const Pose2 beside = kReferencePose * Pose2{0.08, 0.0, 0.0};  // two walls are off by 8 cm, two by nothing
  EXPECT_LT(overlapAt(reference, points, beside, 0.05), there - 0.2);
  EXPECT_GT(overlapAt(reference, points, beside, 0.15), 0.97);
  EXPECT_EQ(overlapAt(reference, {}, kReferencePose, 0.05), 0.0);
}

}  // namespace
}  // namespace slam::plicp_test
