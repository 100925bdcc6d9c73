// SPDX-License-Identifier: BSD-3-Clause
// What a closure claims, and the limits beyond which LoopClosureSearch refuses one.
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "relocalisation/loop_closure.hpp"
#include "support/property.hpp"
#include "support/simulated/keyframes.hpp"

namespace slam::closure_limits_test {
namespace {

using test::draw;

Eigen::Matrix3d drawCovariance() {
  Eigen::Matrix3d root;
  for (int i = 0; i < 9; ++i) root(i) = draw(-0.05, 0.05);
  return root * root.transpose() + 1e-5 * Eigen::Matrix3d::Identity();
}

/// A small motion of a pose in map, as the match's covariance counts it.
Pose2 displaced(const Pose2& pose, const Eigen::Vector3d& by) { return Pose2::fromVector(pose.vector() + by); }

RC_GTEST_PROP(ClosureInformation, IsTheMatchsCovarianceInMapAndItsFloor, ()) {
  MatchResult match;
  match.T_ref_base = test::drawPose(10.0);
  match.covariance = drawCovariance();
  match.observable = 3;
  const Pose2 T_map_from = test::drawPose(10.0);
  const Edge edge{.from = 0,
                  .to = 1,
                  .T_from_to = between(T_map_from, match.T_ref_base),
                  .information = closureInformation(match, 0.02, 0.005)};
  const Eigen::Vector3d by(draw(-0.1, 0.1), draw(-0.1, 0.1), draw(-0.1, 0.1));
  Eigen::Matrix3d covariance = match.covariance;
  covariance.diagonal() += Eigen::Vector3d(0.02 * 0.02, 0.02 * 0.02, 0.005 * 0.005);
  const double expected = by.dot(covariance.inverse() * by);
  const double actual = chiSquare(edge, T_map_from, displaced(match.T_ref_base, by));
  RC_ASSERT(std::abs(actual - expected) < 1e-6 * (1.0 + expected));
}

RC_GTEST_PROP(ClosureInformation, ReportsNothingAlongWhatTheMatchDidNotSee, ()) {
  MatchResult match;
  match.T_ref_base = test::drawPose(10.0);
  match.covariance = drawCovariance();
  match.observable = 2;
  const Eigen::Vector3d blind = Eigen::Vector3d(draw(-1, 1), draw(-1, 1), draw(-0.3, 0.3) + 0.01).normalized();
  const Eigen::Vector3d seen = blind.unitOrthogonal(), other = blind.cross(seen);
  match.directions << seen, other, blind;
  const Pose2 T_map_from = test::drawPose(10.0);
  const Edge edge{.from = 0,
                  .to = 1,
                  .T_from_to = between(T_map_from, match.T_ref_base),
                  .information = closureInformation(match, 0.02, 0.005)};
  const double along = chiSquare(edge, T_map_from, displaced(match.T_ref_base, 0.1 * blind));
  RC_ASSERT(along < 1e-6);
  Eigen::Matrix3d covariance = match.covariance;
  covariance.diagonal() += Eigen::Vector3d(0.02 * 0.02, 0.02 * 0.02, 0.005 * 0.005);
  Eigen::Matrix<double, 3, 2> U;
  U << seen, other;
  const Eigen::Vector2d by(draw(-0.1, 0.1), draw(-0.1, 0.1));
  const double expected = by.dot((U.transpose() * covariance * U).inverse() * by);
  const double actual = chiSquare(edge, T_map_from, displaced(match.T_ref_base, U * by));
  RC_ASSERT(std::abs(actual - expected) < 1e-6 * (1.0 + expected));
}

RC_GTEST_PROP(ChiSquareProperty, StaysAsTheMapIsMoved, ()) {
  const Edge edge{.from = 0, .to = 1, .T_from_to = test::drawPose(3.0), .information = drawCovariance().inverse()};
  const Pose2 a = test::drawPose(10.0), T_new_map = test::drawPose(50.0);
  const Pose2 b = a * edge.T_from_to * Pose2{draw(-0.3, 0.3), draw(-0.3, 0.3), draw(-0.3, 0.3)};
  const double here = chiSquare(edge, a, b), there = chiSquare(edge, T_new_map * a, T_new_map * b);
  RC_ASSERT(std::abs(here - there) < 1e-8 * (1.0 + here));
}

RC_GTEST_PROP(ChiSquareProperty, ErrsInTheAxesOfTheMeasuredPose, ()) {
  const Edge edge{.from = 0, .to = 1, .T_from_to = test::drawPose(3.0), .information = drawCovariance().inverse()};
  const Pose2 a = test::drawPose(10.0);
  const Pose2 error{draw(-0.3, 0.3), draw(-0.3, 0.3), draw(-0.3, 0.3)};
  const double expected = error.vector().dot(edge.information * error.vector());
  RC_ASSERT(std::abs(chiSquare(edge, a, a * edge.T_from_to * error) - expected) < 1e-8 * (1.0 + expected));
}

const Eigen::Vector3d kSharp(0.004, 0.004, 0.001);  // [m, m, rad] claimed of an ordinary step
const Pose2 kStart{-1.9, -0.9, 0.0};
constexpr int kVisit = 15;  // keyframes

/// A room that is visited twice.
struct Visits {
  explicit Visits(const LoopClosureConfig& config = {})
      : drive(test::furnishedRoom()),
        search(std::make_unique<LoopClosureSearch>(config, PlaceSearchConfig{}, ReferenceConfig{}, MatchConfig{})) {}

  void goOn(const Pose2& truth, const Pose2& error = {}, const Eigen::Vector3d& sigma = kSharp) {
    keyframes.add(drive.at(truth, error, sigma));
    const std::vector<char> in_map(static_cast<std::size_t>(keyframes.size()), 1);
    for (const Edge& edge : search->search(keyframes, in_map)) accepted.push_back(edge);
  }
  void straightOn(const Pose2& start, int count, const Pose2& error = {}, const Eigen::Vector3d& sigma = kSharp) {
    for (int i = 0; i < count; ++i)
      goOn(start * Pose2{0.25 * i, 0, 0}, i == 0 ? error : Pose2{}, i == 0 ? sigma : kSharp);
  }
  double worst() const {
    double metres = 0.0;
    for (const Edge& edge : accepted) {
      const Pose2 error = between(drive.trueRelative(edge.from, edge.to), edge.T_from_to);
      metres = std::max(metres, std::hypot(error.x, error.y));
    }
    return metres;
  }

  test::KeyframeDrive drive;
  KeyframeGraph keyframes;
  std::unique_ptr<LoopClosureSearch> search;
  std::vector<Edge> accepted;
};

TEST(LoopClosureLimits, TwoClosuresThatDifferInHeadingAloneContradictEachOther) {
  for (const auto& [consistency, turned, agree] : {std::tuple(0.3, 0.35, false), std::tuple(0.3, -0.35, false),
                                                   std::tuple(0.3, 0.2, true), std::tuple(0.4, 0.35, true)}) {
    LoopClosureConfig config;
    config.query_length = 0.1;  // the newest scan alone
    config.agreement_distance = 0.0;
    config.consistency = consistency;
    Visits visits(config);
    visits.straightOn(kStart, kVisit);
    visits.goOn(kStart, {-0.4, 0.2, 0.0}, {0.4, 0.4, 0.15});
    ASSERT_EQ(visits.search->counters().found, 1);
    visits.goOn(kStart * Pose2{0.6, 0.0, 0.0}, {0.0, 0.0, turned});  // a wheel spun, and nobody noticed
    EXPECT_EQ(visits.search->counters().found, 2);
    EXPECT_EQ(visits.search->counters().inconsistent, agree ? 0 : 1) << turned;
    EXPECT_EQ(visits.accepted.size(), agree ? 2U : 0U) << turned;
  }
}

TEST(LoopClosureLimits, TwoClosuresThatLieApartContradictEachOther) {
  for (const auto& [off, agree] :
       {std::pair(Pose2{0.35, 0, 0}, false), std::pair(Pose2{0, 0.35, 0}, false), std::pair(Pose2{0, -0.35, 0}, false),
        std::pair(Pose2{0.25, 0, 0}, true), std::pair(Pose2{0, 0.25, 0}, true)}) {
    LoopClosureConfig config;
    config.query_length = 0.1;
    config.agreement_distance = 0.0;
    Visits visits(config);
    visits.straightOn(kStart, kVisit);
    visits.goOn(kStart, {-0.4, 0.2, 0.0}, {0.4, 0.4, 0.1});
    ASSERT_EQ(visits.search->counters().found, 1);
    visits.goOn(kStart * Pose2{0.6, 0.0, 0.0}, off);
    EXPECT_EQ(visits.search->counters().found, 2) << off.x << " " << off.y;
    EXPECT_EQ(visits.search->counters().inconsistent, agree ? 0 : 1) << off.x << " " << off.y;
  }
}

TEST(LoopClosureLimits, KeyframesThatAreOneMapWithTheRobotAreNotMatchedAgainst) {
  // Between the old visit and the robot lies a stretch that is one map with either, and lies wrong with the robot: it
  // would match itself.
  for (const Pose2& error : {Pose2{0.0, 0.13, 0.0}, Pose2{-0.12, 0.0, 0.0}}) {
    Visits visits;
    visits.straightOn(kStart, kVisit);
    const Eigen::Vector3d vague(0.045, 0.045, 0.004);
    visits.straightOn(kStart * Pose2{0.0, 0.2, 0.0}, 6, error, vague);
    visits.straightOn(kStart * Pose2{0.5, 0.3, 0.0}, 8, {}, vague);
    ASSERT_FALSE(visits.accepted.empty());
    EXPECT_LT(visits.worst(), 0.03);
    for (const Edge& edge : visits.accepted) EXPECT_LT(edge.from, kVisit);
  }
}

TEST(LoopClosureLimits, WhatIsKnownWellEnoughIsOneMap) {
  for (const auto& [sigma, searches] : {std::pair(0.045, false), std::pair(0.055, true)}) {
    Visits visits;
    visits.straightOn(kStart, 1);
    visits.straightOn(kStart, 8, {}, {sigma, sigma, 1e-4});
    EXPECT_EQ(visits.search->counters().searches > 0, searches) << sigma;
  }
  LoopClosureConfig vague;
  vague.active_sigma = 0.06;
  Visits visits(vague);
  visits.straightOn(kStart, 1);
  visits.straightOn(kStart, 8, {}, {0.055, 0.055, 1e-4});
  EXPECT_EQ(visits.search->counters().searches, 0);
}

TEST(LoopClosureLimits, AClosureOfLittleOverlapWaitsForAnother) {
  const auto acceptedAtFirst = [](double sure_overlap, double sure_window) {
    LoopClosureConfig config;
    config.sure_overlap = sure_overlap;
    config.sure_window = sure_window;
    Visits visits(config);
    visits.straightOn(kStart, kVisit);
    visits.goOn(kStart * Pose2{0.1, 0.15, 0.1}, {0.2, -0.15, 0.05}, {0.12, 0.12, 0.03});
    EXPECT_EQ(visits.search->counters().found, 1);
    return !visits.accepted.empty();
  };
  EXPECT_TRUE(acceptedAtFirst(0.7, 1.0));
  EXPECT_FALSE(acceptedAtFirst(1.01, 1.0)) << "no closure is sure by its overlap";
  EXPECT_FALSE(acceptedAtFirst(0.7, 0.3)) << "the window of 0.36 m is a wide one";
}

TEST(LoopClosureLimits, LooksNoFurtherThanTheDriftAndALookAroundTheCorner) {
  for (const auto& [away, searches] : {std::pair(2.2, true), std::pair(2.5, false)}) {
    Visits visits;
    visits.drive.place = test::hallWithPillars();
    visits.goOn({-6.0, 0.0, 0.0});
    visits.goOn({-6.0 + away, 0.0, 0.0}, {}, {0.1, 0.1, 1e-4});  // a window of 0.3 m
    EXPECT_EQ(visits.search->counters().searches > 0, searches) << away;
  }
}

TEST(LoopClosureSubmap, IsDrawnAnewWhereAKeyframeHasMovedOrChanged) {
  constexpr int kMet = 7;
  Visits visits;
  visits.straightOn(kStart, kVisit);
  visits.straightOn(kStart * Pose2{0.1, 0.15, 0.1}, kVisit, {0.25, -0.2, 0.05}, {0.12, 0.12, 0.03});
  const int newest = visits.keyframes.size() - 1;
  const LoopClosureSearch::Candidate candidate{kMet, visits.keyframes.pose(newest), {0.5, 0.1}};
  const auto verified = [&](LoopClosureSearch& search) {
    const auto edge = search.verify(visits.keyframes, newest, candidate);
    return edge ? edge->T_from_to : Pose2{};
  };
  const auto anew = [&] {
    LoopClosureSearch search(LoopClosureConfig{}, PlaceSearchConfig{}, ReferenceConfig{}, MatchConfig{});
    return verified(search);
  };
  LoopClosureSearch search(LoopClosureConfig{}, PlaceSearchConfig{}, ReferenceConfig{}, MatchConfig{});
  const Pose2 first = verified(search);
  ASSERT_NE(first, Pose2{});
  EXPECT_EQ(verified(search), first) << "nothing has changed";

  PoseGraph& graph = visits.keyframes.graph();
  for (int id = 0; id < kVisit; ++id)
    if (id != kMet) graph.setPose(id, graph.pose(id) * Pose2{0.02, 0.01, 0.0});
  const Pose2 moved = verified(search);
  EXPECT_NE(moved, first);
  EXPECT_EQ(moved, anew());

  for (int id = 0; id < kMet; ++id) visits.keyframes.setScan(id, std::make_shared<const StoredScan>());
  const Pose2 changed = verified(search);
  EXPECT_NE(changed, moved);
  EXPECT_EQ(changed, anew());
}

}  // namespace
}  // namespace slam::closure_limits_test
