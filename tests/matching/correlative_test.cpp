// SPDX-License-Identifier: BSD-3-Clause
#include "matching/correlative.hpp"

#include <gtest/gtest.h>
#include <numbers>

#include "matching/plicp.hpp"
#include "matching/scanning.hpp"
#include "support/allocations.hpp"

namespace slam::correlative_test {
namespace {

using test::Room;
using test::scanPoints;

constexpr Pose2 kReferencePose{0.9, -0.4, 0.1};  // off every symmetry of the room
const Room kRoom{.length = 7.0, .width = 4.0, .range_sigma = 0.015};

double distance(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// A room is the same after half a turn about its middle, so the reference is seen from beside it.
class CorrelativeSearch : public testing::Test {
 protected:
  CorrelativeSearch() { reference.add(kReferencePose, scanPoints(kRoom, kReferencePose, random)); }
  std::mt19937 random{1};
  Reference reference;
  CorrelativeMatcher matcher;
};

TEST_F(CorrelativeSearch, FindsAnyPoseOfItsWindowUnderNoise) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const SearchWindow window{0.8, 1.0};
  for (int trial = 0; trial < 200; ++trial) {
    const Pose2 truth{kReferencePose.x + 0.3 * uniform(random), kReferencePose.y + 0.3 * uniform(random),
                      kReferencePose.theta + 0.3 * uniform(random)};
    const Pose2 guess{truth.x + 0.8 * uniform(random), truth.y + 0.8 * uniform(random), truth.theta + uniform(random)};
    const SearchResult result = matcher.match(reference, scanPoints(kRoom, truth, random), guess, window, {});
    ASSERT_TRUE(result.match.usable()) << trial;
    ASSERT_LT(distance(result.match.T_ref_base, truth), 0.03) << trial;
    ASSERT_LT(std::abs(wrapAngle(result.match.T_ref_base.theta - truth.theta)), 0.02) << trial;
  }
}

TEST_F(CorrelativeSearch, CallsASymmetricPlaceAmbiguousWhenTheWindowHoldsBothAnswers) {
  const SearchWindow all{3.0, std::numbers::pi};
  const SearchResult result = matcher.match(reference, scanPoints(kRoom, kReferencePose, random), {}, all, {});
  EXPECT_EQ(result.match.status, MatchStatus::kAmbiguous);
  EXPECT_GT(result.runner_up, 0.95);
}

TEST_F(CorrelativeSearch, RefusesAScanOfAnotherPlace) {
  const Room other{.length = 2.6, .width = 2.2, .range_sigma = 0.015};
  EXPECT_FALSE(matcher.match(reference, scanPoints(other, {}, random), {}, {2.0, 3.1}, {}).match.usable());
}

TEST_F(CorrelativeSearch, TrustsADirectMatchThatAgrees) {
  const auto points = scanPoints(kRoom, kReferencePose, random);
  const SearchResult result = matcher.matchOrSearch(reference, points, kReferencePose, {3.0, 3.1}, {});
  EXPECT_EQ(result.match.status, MatchStatus::kConverged);  // a search of so wide a window would be ambiguous
}

TEST_F(CorrelativeSearch, SearchesWhereADirectMatchEndsInAWrongMinimum) {
  const auto points = scanPoints(kRoom, kReferencePose, random);
  const Pose2 guess{kReferencePose.x + 0.5, kReferencePose.y - 0.5, kReferencePose.theta + 1.2};
  ASSERT_GT(distance(matcher.matchOrSearch(reference, points, guess, {0.0, 0.0}, {}).match.T_ref_base, kReferencePose),
            0.05);
  const SearchResult result = matcher.matchOrSearch(reference, points, guess, {0.8, 1.4}, {});
  EXPECT_TRUE(result.match.usable());
  EXPECT_LT(distance(result.match.T_ref_base, kReferencePose), 0.03);
}

TEST_F(CorrelativeSearch, RefusesTooFewPointsAndAnEmptyReference) {
  EXPECT_FALSE(matcher.match(reference, {}, {}, {}, {}).match.usable());
  const Reference empty;
  EXPECT_FALSE(matcher.match(empty, scanPoints(kRoom, {}, random), {}, {}, {}).match.usable());
}

TEST_F(CorrelativeSearch, DoesNotAllocate) {
  const auto points = scanPoints(kRoom, kReferencePose, random);
  EXPECT_EQ(test::allocationsDuring([&] { matcher.match(reference, points, {}, {3.0, 3.0}, {}); }), 0U);
}

TEST_F(CorrelativeSearch, ASecondPlaceIsAmbiguousFromItsShareOfTheBestOn) {
  const SearchWindow all{3.0, std::numbers::pi};
  const auto points = scanPoints(kRoom, kReferencePose, random);
  const double share = matcher.match(reference, points, {}, all, {}).runner_up;
  ASSERT_GT(share, 0.5);
  const auto status = [&](double ambiguity) {
    return CorrelativeMatcher({.ambiguity = ambiguity}).match(reference, points, {}, all, {}).match.status;
  };
  EXPECT_EQ(status(share - 0.005), MatchStatus::kAmbiguous);
  EXPECT_EQ(status(share + 0.005), MatchStatus::kConverged);
}

TEST_F(CorrelativeSearch, PlacesAreTwoWhereTheyLieApartOrAreTurned) {
  // The two places of the room are half a turn and some distance apart: neither limit alone makes them one.
  const SearchWindow all{3.0, std::numbers::pi};
  const auto points = scanPoints(kRoom, kReferencePose, random);
  const auto runnerUp = [&](double distance, double rotation) {
    return CorrelativeMatcher({.distinct_distance = distance, .distinct_rotation = rotation})
        .match(reference, points, {}, all, {})
        .runner_up;
  };
  EXPECT_GT(runnerUp(0.5, 4.0), 0.9) << "by the distance";
  EXPECT_GT(runnerUp(50.0, 0.35), 0.9) << "by the turn";
  EXPECT_EQ(runnerUp(50.0, 4.0), 0.0) << "by neither";
}

TEST_F(CorrelativeSearch, ADirectMatchIsTrustedFromItsOverlapOn) {
  const auto points = scanPoints(kRoom, kReferencePose, random);
  const double overlap = matchPointToLine(reference, points, kReferencePose).overlap;
  const auto status = [&](double trusted) {
    return CorrelativeMatcher({.trusted_overlap = trusted})
        .matchOrSearch(reference, points, kReferencePose, {3.0, 3.1}, {})
        .match.status;
  };
  EXPECT_EQ(status(overlap), MatchStatus::kConverged);
  EXPECT_EQ(status(overlap + 0.01), MatchStatus::kAmbiguous) << "it searches, and finds two places";
}

/// A corridor along a direction, with a few posts that tell too little of the way for a match to claim it.
ScanPoints corridorWithPosts(const Pose2& pose, const Pose2& corridor) {
  ScanPoints points;
  const PointTransform T(pose.inverse() * corridor);
  for (int i = -100; i <= 100; ++i) {
    for (const double side : {-1.0, 1.0}) {
      points.push_back({.position = T * Eigen::Vector2d(0.04 * i, side),
                        .normal = T.turned({0.0, -side}),
                        .normal_variance = 1e-4,
                        .range = 2.0});
    }
  }
  for (const double x : {-2.1, -1.3, -0.2, 0.4, 1.9}) {
    for (const double y : {-0.6, 0.5, 0.55}) {
      points.push_back({.position = T * Eigen::Vector2d(x, y), .range = 2.0});
    }
  }
  return points;
}

TEST_F(CorrelativeSearch, SlidesAlongABlindDirectionToWhereMostPointsMeet) {
  const MatchConfig blind{.min_information = 0.08};
  for (const double bearing : {0.0, 0.7, -1.2}) {
    const Pose2 corridor{0.3, -0.2, bearing};
    Reference walls;
    for (int i = 0; i < 3; ++i) walls.add({}, corridorWithPosts({}, corridor));
    const Pose2 truth = corridor * Pose2{0.1, 0.05, 0.03};
    const auto points = corridorWithPosts(truth, corridor);
    const Pose2 guess = corridor * Pose2{0.1 - 0.25, 0.05, 0.03};  // the hypotheses lie as far off
    CorrelativeMatcher all({.translation_step = 0.5, .max_points = 500});
    const MatchResult searched = all.match(walls, points, guess, {0.6, 0.1}, blind).match;
    ASSERT_EQ(searched.observable, 2) << bearing;
    EXPECT_LT(distance(searched.T_ref_base, truth), 0.15) << bearing;
    const MatchResult direct = all.matchOrSearch(walls, points, guess, {0.6, 0.1}, blind).match;
    ASSERT_EQ(direct.observable, 2) << bearing;
    EXPECT_LT(distance(direct.T_ref_base, truth), 0.04) << bearing;
    EXPECT_GT(distance(all.matchOrSearch(walls, points, guess, {0.1, 0.1}, blind).match.T_ref_base, truth), 0.12)
        << "no further than the window";
  }
}

TEST_F(CorrelativeSearch, LooksAsFarAsItsWindowAndNoFurther) {
  const Pose2 truth{0.5, -0.1, 0.2};
  const auto points = scanPoints(kRoom, truth, random);
  MatchConfig near;  // a hypothesis must lie within a step of the truth
  near.initial_pair_distance = near.final_pair_distance = 0.25;
  CorrelativeMatcher fine({.translation_step = 0.1});
  for (const Pose2& off : {Pose2{0.9, 0, 0}, Pose2{0, -0.9, 0}, Pose2{0, 0, 0.9}, Pose2{0, 0, -0.9}}) {
    const Pose2 guess{truth.x + off.x, truth.y + off.y, truth.theta + off.theta};
    const auto found = [&](const SearchWindow& window) {
      return distance(fine.match(reference, points, guess, window, near).match.T_ref_base, truth) < 0.03;
    };
    EXPECT_TRUE(found({1.0, 1.0})) << off.x << off.y << off.theta;
    if (off.y == 0.0) {  // across the room the match itself finds the way
      EXPECT_FALSE(found({0.3, 0.2})) << off.x << off.theta;
    }
  }
}

TEST_F(CorrelativeSearch, ThePlaceThatABetterOneReplacesIsItsSecond) {
  // The coarse search ranks the room's other place first; three posts, which its sample leaves out, say otherwise.
  const auto posts = [](const Pose2& pose) {
    ScanPoints points;
    for (const Eigen::Vector2d& p :
         {Eigen::Vector2d(0.3, 0.9), Eigen::Vector2d(-1.2, 0.7), Eigen::Vector2d(2.0, 1.1)}) {
      points.push_back({.position = pose.inverse() * p, .range = 1.5});
    }
    return points;
  };
  reference.add(kReferencePose, posts(kReferencePose));
  auto points = scanPoints(kRoom, kReferencePose, random);
  for (const ScanPoint& post : posts(kReferencePose)) points.push_back(post);
  CorrelativeMatcher few({.refined = 2});
  const SearchResult result = few.match(reference, points, {}, {3.0, std::numbers::pi}, {});
  ASSERT_LT(distance(result.match.T_ref_base, kReferencePose), 0.05);
  EXPECT_GT(result.runner_up, 0.9);
  EXPECT_LT(result.runner_up, 1.0);
}

TEST_F(CorrelativeSearch, SlidesForAClearGainAlone) {
  const MatchConfig blind{.min_information = 0.08};
  Reference walls;
  for (int i = 0; i < 3; ++i) walls.add({}, corridorWithPosts({}, {}));
  const Pose2 truth{0.1, 0.05, 0.03}, guess{0.1 - 0.25, 0.05, 0.03};
  for (const auto& [gain, slides] : {std::pair(0.02F, true), std::pair(0.5F, false)}) {
    CorrelativeMatcher sliding({.max_points = 500, .clear_gain = gain});
    const Pose2 found =
        sliding.matchOrSearch(walls, corridorWithPosts(truth, {}), guess, {0.6, 0.1}, blind).match.T_ref_base;
    EXPECT_EQ(distance(found, truth) < 0.05, slides) << gain;
    EXPECT_EQ(distance(found, guess) < 0.05, !slides) << gain;
  }
}

}  // namespace
}  // namespace slam::correlative_test
