// SPDX-License-Identifier: BSD-3-Clause
#include "matching/correlative.hpp"

#include <gtest/gtest.h>
#include <numbers>

#include "matching/scanning.hpp"
#include "support/allocations.hpp"

namespace slam {
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

TEST_F(CorrelativeSearch, DoesNotTurnRoundInACorridorHoweverMuchBetterItFits) {
  // Nobody sees its ends; one wall has stretches that the other has not, so that one way round fits better.
  const Room corridor{.length = 60.0, .width = 2.0, .reach = 6.0, .range_sigma = 0.015};
  const auto seen = [&](const Pose2& pose) {
    auto points = scanPoints(corridor, pose, random);
    std::erase_if(points, [&](const ScanPoint& p) {
      const Eigen::Vector2d wall = pose * p.position;
      return wall.y() > 0.0 && std::abs(std::remainder(wall.x() - 1.0, 6.0)) < 1.2;
    });
    return points;
  };
  Reference walls;
  for (double x = -4.0; x <= 4.0; x += 1.0) walls.add({x, 0.0, 0.0}, seen({x, 0.0, 0.0}));
  const SearchWindow window{0.2, std::numbers::pi};
  for (const double turn : {-3.0, -2.4, 2.4, 3.0}) {
    const SearchResult round = matcher.match(walls, seen({0.0, 0.0, turn}), {}, window, {});
    ASSERT_LT(round.runner_up, 0.95) << "one way fits better";
    EXPECT_EQ(round.match.status, MatchStatus::kAmbiguous) << turn;
  }
  for (const double turn : {-0.8, 0.1, 0.8}) {
    const SearchResult along = matcher.match(walls, seen({0.0, 0.0, turn}), {}, window, {});
    ASSERT_TRUE(along.match.usable()) << turn;
    EXPECT_LT(std::abs(along.match.T_ref_base.theta - turn), 0.02);
  }
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

}  // namespace
}  // namespace slam
