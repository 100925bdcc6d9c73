// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/loop_closure.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "support/simulated/keyframes.hpp"

namespace slam::loop_closure_test {
namespace {

using test::KeyframeDrive;

const Eigen::Vector3d kSharp(0.004, 0.004, 0.001);  // [m, m, rad] claimed of an ordinary step
constexpr double kStep = 0.25;                      // [m]
constexpr int kVisit = 15;                          // keyframes

/// Visits a place, comes back by a step of which little is known, and visits it again.
class Visits {
 public:
  explicit Visits(test::Place place, const LoopClosureConfig& config = {}, int forgotten = 0)
      : drive(std::move(place)),
        forgotten_(forgotten),
        search_(std::make_unique<LoopClosureSearch>(config, PlaceSearchConfig{}, ReferenceConfig{}, MatchConfig{})) {}

  void goOn(const Pose2& truth, const Pose2& error, const Eigen::Vector3d& sigma) {
    keyframes.add(drive.at(truth, error, sigma));
    in_map_.push_back(keyframes.size() > forgotten_);
    newest = search_->search(keyframes, in_map_);
    accepted.insert(accepted.end(), newest.begin(), newest.end());
  }
  void goOn(const Pose2& truth) { goOn(truth, {}, kSharp); }
  /// Straight on. @param start first pose, to which the robot comes by a step with this error and standard deviation
  void visit(const Pose2& start, const Pose2& error, const Eigen::Vector3d& sigma, int count = kVisit,
             const Pose2& step = {kStep, 0.0, 0.0}) {
    Pose2 truth = start;
    goOn(truth, error, sigma);
    for (int i = 1; i < count; ++i) goOn(truth = truth * step);
  }

  void expectRight(double position, double heading) const {
    for (const Edge& edge : accepted) {
      const Pose2 error = between(drive.trueRelative(edge.from, edge.to), edge.T_from_to);
      EXPECT_LT(std::hypot(error.x, error.y), position) << edge.from << " - " << edge.to;
      EXPECT_LT(std::abs(error.theta), heading) << edge.from << " - " << edge.to;
      EXPECT_LT(chiSquare(edge, {}, drive.trueRelative(edge.from, edge.to)), 16.0) << edge.from << " - " << edge.to;
      EXPECT_EQ(edge.kind, EdgeKind::kLoopClosure);
      EXPECT_FALSE(edge.revoked);
    }
  }
  const LoopClosureSearch::Counters& counters() const { return search_->counters(); }

  KeyframeDrive drive;
  KeyframeGraph keyframes;
  std::vector<Edge> newest, accepted;

 private:
  int forgotten_;  // of the first keyframes
  std::vector<char> in_map_;
  std::unique_ptr<LoopClosureSearch> search_;
};

const Pose2 kStart{-1.9, -0.9, 0.0};

TEST(LoopClosureSearch, ClosesASecondVisitThatDrifted) {
  for (const Pose2& error : {Pose2{0.25, -0.2, 0.05}, Pose2{-0.3, 0.1, -0.06}, Pose2{}}) {
    Visits visits(test::furnishedRoom());
    visits.visit(kStart, {}, kSharp);
    EXPECT_EQ(visits.counters().searches, 0) << "all is known well";
    visits.visit(kStart * Pose2{0.1, 0.15, 0.1}, error, {0.12, 0.12, 0.03});
    ASSERT_FALSE(visits.accepted.empty());
    visits.expectRight(0.03, 0.01);
    for (const Edge& edge : visits.accepted) {
      EXPECT_LT(edge.from, kVisit);
      EXPECT_GE(edge.to, kVisit);
    }
  }
}

TEST(LoopClosureSearch, PassesOverWhatIsNotPartOfTheMap) {
  Visits visits(test::furnishedRoom(), {}, kVisit);
  visits.visit(kStart, {}, kSharp);
  visits.visit(kStart * Pose2{0.1, 0.15, 0.1}, {0.25, -0.2, 0.05}, {0.12, 0.12, 0.03});
  EXPECT_EQ(visits.counters().searches, 0);
  EXPECT_TRUE(visits.accepted.empty());
}

TEST(LoopClosureSearch, ClosesTheRoundOfACorridorUnderNoise) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Visits visits(test::ringCorridor());
    visits.drive.random.seed(seed);
    std::normal_distribution<double> normal;
    const Eigen::Vector3d sigma(0.01, 0.01, 0.002);
    for (double s = 1.0; s < 46.0; s += 0.5) {
      const Eigen::Vector3d e(normal(visits.drive.random), normal(visits.drive.random), normal(visits.drive.random));
      visits.goOn(test::onRing(s), Pose2::fromVector(sigma.cwiseProduct(e)), sigma);
    }
    ASSERT_FALSE(visits.accepted.empty()) << seed;
    visits.expectRight(0.06, 0.02);
    bool joins_the_ends = false;
    for (const Edge& edge : visits.accepted) joins_the_ends |= edge.to - edge.from > 60;
    EXPECT_TRUE(joins_the_ends) << seed;
  }
}

TEST(LoopClosureSearch, LooksForNothingWhereAllIsKnown) {
  Visits visits(test::furnishedRoom());
  visits.visit(kStart, {}, kSharp);
  visits.visit(kStart, {}, kSharp);
  EXPECT_EQ(visits.counters().searches, 0);
}

TEST(LoopClosureSearch, LooksForNothingFarFromAnOldPlace) {
  Visits visits(test::hallWithPillars());
  visits.visit({-11.0, 0.0, 0.0}, {}, kSharp, 5);
  visits.visit({4.0, 0.0, 0.0}, {}, {0.3, 0.3, 0.05}, 10);
  EXPECT_EQ(visits.counters().searches, 0);
}

TEST(LoopClosureSearch, SearchesOnceAnIntervalOfTheWay) {
  LoopClosureConfig config;
  config.min_overlap = 1.1;  // nothing is ever found
  Visits visits(test::furnishedRoom(), config);
  visits.visit(kStart, {}, kSharp);
  visits.visit(kStart, {}, {0.12, 0.12, 0.03}, 13);  // 3 m
  EXPECT_EQ(visits.counters().searches, 7);
  EXPECT_EQ(visits.counters().found, 0);
}

TEST(LoopClosureSearch, RefusesAPlaceThatOnlyLiesThere) {
  Visits visits(test::furnishedRoom());
  visits.visit(kStart, {}, kSharp);
  visits.drive.place = test::endlessCorridor();
  visits.visit(kStart * Pose2{0.0, 0.6, 0.0}, {}, {0.12, 0.12, 0.03});
  EXPECT_GT(visits.counters().searches, 0);
  EXPECT_EQ(visits.counters().accepted, 0);
}

/// Two rooms side by side, 4 m from middle to middle. @param alike both are furnished alike
test::Place twoRooms(bool alike) {
  test::Place place{.name = "TwoRooms", .low = {-1.5, -1.3}, .high = {5.5, 1.3}};
  for (const double x : {0.0, 4.0}) {
    test::addWalls(place.world, {{x - 1.9, -1.6}, {x + 1.9, -1.6}, {x + 1.9, 1.6}, {x - 1.9, 1.6}});
    place.world.add(sim::Box{x - 1.2, 1.3, 0.0, 0.9, 0.4});
    place.world.add(sim::Cylinder{x + 1.2, -1.1, 0.2});
    if (alike || x > 0.0) continue;
    place.world.add(sim::Box{1.2, 1.0, 0.3, 1.0, 0.9});
    place.world.add(sim::Box{-1.6, -0.9, 0.0, 0.5, 1.2});
  }
  return place;
}

TEST(LoopClosureSearch, DoesNotChooseBetweenTwoRoomsThatLookAlike) {
  for (const bool alike : {true, false}) {
    LoopClosureConfig config;
    config.agreement_distance = 1.0;  // the rooms are small
    Visits visits(twoRooms(alike), config);
    for (const double x : {0.0, 4.0}) visits.visit({x - 0.7, 0.0, 0.0}, {}, kSharp, 6);
    ASSERT_EQ(visits.counters().searches, 0);
    visits.visit({-0.8, 0.0, 0.0}, {1.8, 0.2, 0.02}, {1.4, 1.4, 0.02}, 8);
    EXPECT_GT(visits.counters().searches, 1);
    if (alike) {
      EXPECT_GT(visits.counters().ambiguous, 0);
      EXPECT_TRUE(visits.accepted.empty());
    } else {
      EXPECT_FALSE(visits.accepted.empty()) << "it was not the likeness that kept the first from being closed";
      visits.expectRight(0.03, 0.01);
    }
  }
}

TEST(LoopClosureSearch, TakesNoPlaceAlongABareCorridorForAnother) {
  int accepted = 0, ambiguous = 0;
  for (const double heading : {0.0, 0.8, -2.0}) {   // of the robot, which moves along the corridor all the same
    for (const double turned : {0.0, 1.5, -2.5}) {  // the second visit against the first
      Visits visits(test::endlessCorridor());
      const auto along = [](double theta) { return Pose2{kStep * std::cos(theta), -kStep * std::sin(theta), 0.0}; };
      visits.visit({-2.0, 0.0, heading}, {}, kSharp, kVisit, along(heading));
      const Pose2 again{-2.0, 0.0, wrapAngle(heading + turned)};
      visits.visit(again, {0.05, 0.05, 0.01}, {0.06, 0.06, 0.01}, kVisit, along(again.theta));
      ambiguous += visits.counters().ambiguous;
      for (const Edge& edge : visits.accepted) {
        ++accepted;
        const Pose2& from = visits.drive.truth[static_cast<std::size_t>(edge.from)];
        const Pose2& to = visits.drive.truth[static_cast<std::size_t>(edge.to)];
        EXPECT_LT(chiSquare(edge, from, to), 12.0) << "the truth contradicts it: " << heading << ", " << turned;
        EXPECT_LT(chiSquare(edge, from, Pose2{0.5, 0.0, 0.0} * to), 16.0) << heading << ", " << turned;
        EXPECT_GT(chiSquare(edge, from, Pose2{0.0, 0.15, 0.0} * to), 16.0) << heading << ", " << turned;
        EXPECT_GT(chiSquare(edge, from, to * Pose2{0.0, 0.0, 0.1}), 16.0) << heading << ", " << turned;
      }
    }
  }
  EXPECT_GT(ambiguous, 5) << "every place fits";
  EXPECT_GT(accepted, 0) << "where only the degenerate direction is left to choose";
}

TEST(LoopClosureSearch, FindsItsPlaceAmongTheDoorsOfACorridor) {
  // The robot comes from beyond the old map's border, where other doors fit those that it sees first.
  int closed = 0;
  for (const double drift : {0.7, 4.0}) {  // [m] along the corridor
    for (unsigned seed = 1; seed <= 2; ++seed) {
      Visits visits(test::corridorWithIrregularDoors(seed));
      visits.visit({0.0, 0.0, 0.0}, {}, kSharp, 110);
      visits.visit({-6.0, 0.2, 0.02}, {seed % 2 == 0 ? drift : -1.2 * drift, 0.2, 0.01}, {drift, 0.3, 0.02}, 100,
                   {kStep, -0.003, 0.0});
      visits.expectRight(0.15, 0.02);
      closed += visits.accepted.empty() ? 0 : 1;
    }
  }
  EXPECT_GE(closed, 3);
}

TEST(LoopClosureSearch, ALoneClosureInAWideWindowWaitsForASecondThatAgrees) {
  LoopClosureConfig config;
  config.agreement_distance = 2.0;  // the room is small
  Visits visits(test::furnishedRoom(), config);
  visits.visit(kStart, {}, kSharp);
  const Pose2 again = kStart * Pose2{0.0, 0.2, 0.0};
  visits.goOn(again, {-0.6, 0.3, 0.05}, {0.5, 0.5, 0.05});
  EXPECT_EQ(visits.counters().found, 1);
  EXPECT_TRUE(visits.accepted.empty());
  int steps = 0;
  while (visits.accepted.empty() && steps < 16) visits.goOn(again * Pose2{++steps * kStep, 0.0, 0.0});
  EXPECT_GE(steps * kStep, config.agreement_distance) << "the same scans prove nothing twice";
  EXPECT_GT(visits.counters().found, 2);
  EXPECT_GE(visits.accepted.size(), 2U);
  EXPECT_EQ(visits.counters().accepted, visits.accepted.size());
  visits.expectRight(0.03, 0.01);
}

TEST(LoopClosureSearch, DoesNotMatchOldKeyframesWithThemselves) {
  // The robot comes back at once: the last keyframes before the step are as near as those behind it.
  for (const Pose2& error : {Pose2{0.3, 0.0, 0.0}, Pose2{0.0, -0.3, 0.0}, Pose2{-0.2, 0.2, 0.05}}) {
    Visits visits(test::furnishedRoom());
    visits.visit(kStart, {}, kSharp);
    visits.visit({1.5, 0.0, -2.8}, error, {0.12, 0.12, 0.03}, 5);
    EXPECT_FALSE(visits.accepted.empty());
    visits.expectRight(0.03, 0.01);
  }
}

TEST(LoopClosureSearch, ForgetsALoneClosureAfterAWhile) {
  LoopClosureConfig config;
  config.pending_distance = 0.3;  // the next search comes too late
  Visits visits(test::furnishedRoom(), config);
  visits.visit(kStart, {}, kSharp);
  visits.visit(kStart * Pose2{0.0, 0.2, 0.0}, {-0.6, 0.3, 0.05}, {0.5, 0.5, 0.05}, 8);
  EXPECT_GT(visits.counters().found, 2);
  EXPECT_TRUE(visits.accepted.empty());
}

TEST(LoopClosureSearch, ClosuresThatContradictEachOtherDoNotCount) {
  LoopClosureConfig config;
  config.query_length = 0.1;  // the newest scan alone
  config.agreement_distance = 0.0;
  Visits visits(test::furnishedRoom(), config);
  visits.visit(kStart, {}, kSharp);
  const Eigen::Vector3d lost(0.5, 0.5, 0.05);
  visits.goOn(kStart, {-0.6, 0.3, 0.05}, lost);
  ASSERT_EQ(visits.counters().found, 1);
  visits.goOn(kStart * Pose2{0.6, 0.0, 0.0}, {0.6, 0.0, 0.0}, kSharp);  // the wheels spun, and nobody noticed
  EXPECT_EQ(visits.counters().found, 2);
  EXPECT_EQ(visits.counters().inconsistent, 1);
  EXPECT_TRUE(visits.accepted.empty());
  visits.goOn(kStart * Pose2{1.2, 0.0, 0.0});
  EXPECT_EQ(visits.accepted.size(), 2U) << "the second and the third agree";
  visits.expectRight(0.03, 0.01);
}

}  // namespace
}  // namespace slam::loop_closure_test
