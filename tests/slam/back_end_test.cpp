// SPDX-License-Identifier: BSD-3-Clause
#include "slam/back_end.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "support/simulated/keyframes.hpp"

namespace slam::back_end_test {
namespace {

using test::KeyframeDrive;
using test::onRing;

constexpr double kStep = 0.5, kRound = 40.0;        // [m]
const Eigen::Vector3d kDrift(0.01, 0.01, 0.002);    // [m, m, rad] a step
const Eigen::Vector3d kSharp(0.004, 0.004, 0.001);  // [m, m, rad]
const Eigen::Vector3d kLost(0.12, 0.12, 0.03);      // [m, m, rad]

const Pose2 kStart{-1.9, -0.9, 0.0}, kDoor{-1.2, 0.7, 0.2};  // the door is out of reach of the path from kStart
constexpr int kVisit = 15;                                   // keyframes

/// Drives a back end over simulated keyframes and keeps the reference that a front end would have.
class Session {
 public:
  explicit Session(test::Place place, const BackEndConfig& config = {}, unsigned seed = 1)
      : drive(std::move(place), seed), back_end(std::make_unique<BackEnd>(config)) {}

  void add(const Keyframe& keyframe, bool may_correct = true) {
    back_end->add(keyframe, may_correct);
    auto next = back_end->takeCorrection();
    if (!next) return;
    ++corrections;
    if (correction) back_end->recycle(std::move(correction));
    correction = std::move(next);
  }
  /// Along the ring. @param from, to [m]
  void round(double from, double to) {
    for (double s = from; s < to; s += kStep) add(drive.at(onRing(s), kDrift));
  }
  /// Straight through a room.
  void visit(int count = kVisit) {
    for (int i = 0; i < count; ++i) add(drive.at(kStart * Pose2{0.25 * i, 0.0, 0.0}, {}, kSharp));
  }
  /// Comes into the room anew, by a step with this error, and visits it once more. @param shift of the whole room
  void comeBack(const Pose2& error, const Eigen::Vector3d& sigma, const Pose2& shift = {}, bool may_correct = true) {
    add(drive.at(shift * kDoor, error, sigma), may_correct);
    for (int i = 0; i < kVisit; ++i) add(drive.at(shift * kStart * Pose2{0.25 * i, 0.0, 0.0}, {}, kSharp), may_correct);
  }

  /// Largest error of a keyframe's position relative to keyframe 0 [m].
  double error() const {
    double largest = 0.0;
    for (int id = 0; id < back_end->keyframes().size(); ++id) {
      const Pose2 estimate = between(back_end->keyframes().pose(0), back_end->keyframes().pose(id));
      largest = std::max(largest, (estimate.translation() - drive.trueRelative(0, id).translation()).norm());
    }
    return largest;
  }
  std::set<int> inReference() const {
    std::set<int> ids;
    if (correction) {
      for (const ReferenceKeyframe& keyframe : correction->keyframes) ids.insert(keyframe.id);
    }
    return ids;
  }
  BackEndCounters counters() const { return back_end->counters(); }

  KeyframeDrive drive;
  std::unique_ptr<BackEnd> back_end;
  std::unique_ptr<MapCorrection> correction;  // the newest
  int corrections = 0;
};

TEST(BackEnd, ClosesTheRoundOfACorridor) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    BackEndConfig config;
    config.close_loops = false;
    Session session(test::ringCorridor(), {}, seed), blind(test::ringCorridor(), config, seed);
    session.round(1.0, 1.2 * kRound);
    blind.round(1.0, 1.2 * kRound);
    EXPECT_GT(blind.error(), 0.15) << seed;
    EXPECT_LT(session.error(), 0.15) << seed;
    EXPECT_LT(session.error(), 0.7 * blind.error()) << seed;
    EXPECT_GT(session.counters().loop_closures, 0) << seed;
    EXPECT_EQ(session.counters().revoked, 0) << seed;
    EXPECT_EQ(session.counters().keyframes, session.back_end->keyframes().size()) << seed;
    // The end of the round has met its beginning.
    const int last = session.back_end->keyframes().size() - 1, same = last - static_cast<int>(kRound / kStep);
    const Pose2 gap =
        between(between(session.back_end->keyframes().pose(same), session.back_end->keyframes().pose(last)),
                session.drive.trueRelative(same, last));
    EXPECT_LT(std::hypot(gap.x, gap.y), 0.15) << seed;  // less is not looked at
    EXPECT_LT(std::abs(gap.theta), 0.03) << seed;
  }
}

TEST(BackEnd, TheMapStaysWhereItWasAsALoopCloses) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Session session(test::ringCorridor(), {}, seed);
    const auto poses = [&] {
      const auto span = session.back_end->keyframes().graph().poses();
      return std::vector<Pose2>(span.begin(), span.end());
    };
    std::vector<Pose2> before;
    for (double s = 1.0; s < 1.2 * kRound && session.back_end->generation() == 0; s += kStep) {
      before = poses();
      session.round(s, s + 0.9 * kStep);
    }
    ASSERT_EQ(session.back_end->generation(), 1) << seed;
    const std::vector<Pose2> after = poses();
    double moved = 0.0, with_first_held = 0.0;  // [m] sums
    for (std::size_t i = 0; i < before.size(); ++i) {
      moved += (after[i].translation() - before[i].translation()).norm();
      with_first_held +=
          (between(after[0], after[i]).translation() - between(before[0], before[i]).translation()).norm();
    }
    EXPECT_GT(with_first_held, 0.0) << seed;
    EXPECT_LT(moved, 0.75 * with_first_held) << seed;
  }
}

TEST(BackEnd, CountsAGenerationForEachChangeOfKnownPoses) {
  Session session(test::ringCorridor());
  session.round(1.0, 20.0);
  EXPECT_EQ(session.back_end->generation(), 0);
  std::vector<Pose2> poses;
  int generation = 0, changes = 0;
  for (double s = 20.0; s < 1.3 * kRound; s += kStep) {
    session.add(session.drive.at(onRing(s), kDrift));
    bool changed = false;
    for (std::size_t i = 0; i < poses.size(); ++i)
      changed |= !(session.back_end->keyframes().pose(static_cast<int>(i)) == poses[i]);
    ASSERT_EQ(session.back_end->generation(), generation + (changed ? 1 : 0)) << s;
    generation = session.back_end->generation();
    changes += changed ? 1 : 0;
    poses.assign(session.back_end->keyframes().graph().poses().begin(),
                 session.back_end->keyframes().graph().poses().end());
  }
  EXPECT_GT(changes, 0);
}

TEST(BackEnd, TheReferenceHoldsOnlyWhatIsKnownRelativeToTheRobot) {
  BackEndConfig config;
  config.closure.min_overlap = 1.1;  // it finds no closure, so the old place stays out of touch
  Session session(test::furnishedRoom(), config);
  session.visit();
  EXPECT_EQ(session.corrections, 0) << "the front end has built all that itself";
  session.comeBack({0.2, 0.1, 0.03}, kLost);
  ASSERT_TRUE(session.correction);
  EXPECT_EQ(*session.inReference().begin(), kVisit) << "an old keyframe is in it";
  EXPECT_EQ(session.back_end->generation(), 0);
  for (const int id : session.inReference()) {
    const auto reached = session.back_end->keyframes().graph().reach(session.correction->newest, 0.1 * 0.1);
    EXPECT_TRUE(std::any_of(reached.begin(), reached.end(), [&](const auto& r) { return r.node == id; })) << id;
  }
}

TEST(BackEnd, AClosureBringsTheOldPlaceBackIntoTheReference) {
  Session session(test::furnishedRoom());
  session.visit();
  session.comeBack({0.25, -0.2, 0.05}, kLost);
  EXPECT_GT(session.counters().loop_closures, 0);
  ASSERT_TRUE(session.correction);
  for (int id = 0; id < kVisit; ++id) EXPECT_TRUE(session.inReference().contains(id)) << id;
  EXPECT_EQ(session.correction->newest, *session.inReference().rbegin());
  EXPECT_TRUE(std::is_sorted(session.correction->keyframes.begin(), session.correction->keyframes.end(),
                             [](const auto& a, const auto& b) { return a.id < b.id; }));
  EXPECT_LT(session.error(), 0.04);
}

TEST(BackEnd, TheReferenceIsDrawnAtTheCorrectedPoses) {
  Session session(test::furnishedRoom());
  session.visit();
  session.comeBack({0.25, -0.2, 0.05}, kLost);
  ASSERT_TRUE(session.correction);
  const auto& surfels = session.correction->reference;
  EXPECT_GT(surfels.size(), 100);
  int near = 0, all = 0;
  for (const Surfel& surfel : surfels.surfels()) {
    if (surfel.observations == 0.0F) continue;
    const Eigen::Vector2d p = session.drive.truth[0] * Eigen::Vector2d(surfel.x, surfel.y);
    near += session.drive.place.world.occupied(p, 0.1, 0.3, 0.06) ? 1 : 0;
    ++all;
  }
  EXPECT_GT(near, 0.98 * all) << "of " << all;
}

TEST(BackEnd, RenewsTheReferenceSeldom) {
  Session session(test::ringCorridor());
  session.round(1.0, 1.5 * kRound);
  EXPECT_GT(session.corrections, 0);
  EXPECT_LT(session.corrections, session.counters().keyframes / 3);
  EXPECT_EQ(session.corrections, session.counters().corrections);
}

TEST(BackEnd, RevokesAClosureThatTheRestContradicts) {
  // The room was moved sideways while the robot was away; the step there is known well sideways, badly along.
  Session session(test::furnishedRoom());
  session.visit();
  const Eigen::Vector3d sigma(0.25, 0.01, 0.001);
  const Pose2 shift{0.0, 0.4, 0.0};
  const Pose2 honest = between(session.drive.truth.back(), kDoor);
  const Pose2 seen = between(session.drive.truth.back(), shift * kDoor);
  session.comeBack(seen.inverse() * honest, sigma, shift);  // the odometry says kDoor, and is right
  EXPECT_GT(session.counters().search.accepted, 0);
  EXPECT_EQ(session.counters().revoked, session.counters().search.accepted);
  EXPECT_EQ(session.counters().loop_closures, 0);
  const Pose2 kept = between(session.back_end->keyframes().pose(0), session.back_end->keyframes().pose(kVisit + 1));
  EXPECT_LT(std::hypot(kept.x, kept.y), 0.05) << "the poses are as without it";
  for (const Edge& edge : session.back_end->keyframes().graph().edges())
    EXPECT_EQ(edge.revoked, edge.kind == EdgeKind::kLoopClosure);
}

TEST(BackEnd, KeepsAClosureThatTheRestAllows) {
  Session session(test::furnishedRoom());
  session.visit();
  const Pose2 honest = between(session.drive.truth.back(), kDoor);
  session.comeBack(honest.inverse() * Pose2{0.4, 0.0, 0.0} * honest, {0.25, 0.01, 0.001});
  EXPECT_GT(session.counters().loop_closures, 0);
  EXPECT_EQ(session.counters().revoked, 0);
  EXPECT_LT(session.error(), 0.04);
}

TEST(BackEnd, LooksAddNoKeyframes) {
  Session session(test::furnishedRoom());
  session.visit(5);
  const auto edges = session.back_end->keyframes().graph().edges().size();
  for (int i = 0; i < 20; ++i) {
    const Pose2 offset{0.02 * i, 0.1, 0.05 * i};
    const Keyframe& look = session.drive.refresh(session.drive.truth[3] * offset, 3);
    session.add(look);
    const auto scans = session.back_end->mapScans(look);
    ASSERT_EQ(scans.size(), 1U);
    const MapScan& scan = scans.front();
    EXPECT_EQ(scan.id, -1);
    EXPECT_EQ(scan.T_map_base, session.back_end->keyframes().pose(3) * look.T_previous_base);
    EXPECT_EQ(scan.scan->points.size(), static_cast<std::size_t>(look.size));
  }
  EXPECT_EQ(session.back_end->keyframes().size(), 5);
  EXPECT_EQ(session.counters().keyframes, 5);
  EXPECT_EQ(session.back_end->keyframes().graph().edges().size(), edges);
}

TEST(BackEnd, GivesTheMapperKeyframesAtTheirCorrectedPoses) {
  Session session(test::furnishedRoom());
  session.visit();
  session.comeBack({0.25, -0.2, 0.05}, kLost);
  const Keyframe& newest = session.drive.at(kStart, {}, kSharp);
  session.add(newest);
  const auto scans = session.back_end->mapScans(newest);
  ASSERT_EQ(scans.size(), 1U);
  const MapScan& scan = scans.front();
  EXPECT_EQ(scan.id, 2 * kVisit + 1);
  EXPECT_EQ(scan.T_map_base, session.back_end->keyframes().pose(scan.id));
  EXPECT_GT((scan.T_map_base.translation() - newest.T_map_base.translation()).norm(), 0.1) << "the front end's pose";
  EXPECT_EQ(scan.scan, session.back_end->keyframes().scan(scan.id));
}

TEST(BackEnd, NeverCorrectsWhereLoopsAreNotToBeClosed) {
  BackEndConfig config;
  config.close_loops = false;
  Session session(test::furnishedRoom(), config);
  session.visit();
  session.comeBack({0.25, -0.2, 0.05}, kLost);
  EXPECT_EQ(session.corrections, 0);
  EXPECT_EQ(session.back_end->generation(), 0);
  EXPECT_EQ(session.counters().search.searches, 0);
  EXPECT_EQ(session.counters().loop_closures, 0);
  for (int id = 0; id < 2 * kVisit + 1; ++id)
    EXPECT_EQ(session.back_end->keyframes().pose(id), session.drive.measured[static_cast<std::size_t>(id)]);
}

TEST(BackEnd, MakesNoCorrectionWhileTheLastIsOnItsWay) {
  Session session(test::furnishedRoom());
  session.visit();
  session.comeBack({0.25, -0.2, 0.05}, kLost, {}, false);
  EXPECT_GT(session.counters().loop_closures, 0);
  EXPECT_EQ(session.corrections, 0);
  session.add(session.drive.refresh(kStart, kVisit + 1));
  EXPECT_EQ(session.corrections, 1) << "a look asks for it, too";
  EXPECT_TRUE(session.inReference().contains(0));
}

TEST(BackEnd, JoinsKeyframesThatWereMatchedToOneReference) {
  // A robot that circles in a room is matched to what it saw in the first circle: the drift does not add up.
  Session session(test::furnishedRoom());
  for (int i = 0; i < 60; ++i) {
    const double angle = 0.3 * i;
    session.add(session.drive.at({0.9 * std::cos(angle), -0.9 * std::sin(angle), -angle}, {}, kDrift));
  }
  const auto reached = session.back_end->keyframes().graph().reach(59, 0.05 * 0.05);
  EXPECT_EQ(reached.size(), 60U);
  EXPECT_EQ(session.counters().search.searches, 0);
}

TEST(BackEnd, JoinsThemOnlyInTheDirectionsThatTheMatchSaw) {
  Session session(test::furnishedRoom());
  session.visit();
  const auto edges = [&] { return session.back_end->keyframes().graph().edges(); };
  const auto linked = [&](int observable) {
    Keyframe keyframe = session.drive.at(kStart * Pose2{0.3, 0.0, 0.9}, {}, kSharp);
    keyframe.observable = observable;
    keyframe.directions << -0.6, 0.0, 0.8, 0.8, 0.0, 0.6, 0.0, 1.0, 0.0;  // blind along (0.8, 0.6) in map
    const std::size_t before = edges().size();
    session.add(keyframe);
    return edges().size() == before + 2 ? std::optional(edges().back()) : std::nullopt;
  };
  EXPECT_FALSE(linked(0)) << "by prediction alone";
  const auto whole = linked(3);
  ASSERT_TRUE(whole);
  EXPECT_GT(whole->information.determinant(), 1e9);
  const auto partly = linked(2);
  ASSERT_TRUE(partly);
  EXPECT_EQ(partly->kind, EdgeKind::kMotion);
  const double turn = -session.back_end->keyframes().pose(partly->to).theta;
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(turn).toRotationMatrix();
  Eigen::Vector3d along = Eigen::Vector3d::Zero(), across = along;
  along.head<2>() = R * Eigen::Vector2d(0.8, 0.6);
  across.head<2>() = R * Eigen::Vector2d(-0.6, 0.8);
  EXPECT_NEAR(along.dot(partly->information * along), 0.0, 1e-6);
  EXPECT_NEAR(across.dot(partly->information * across), 1.0 / (0.02 * 0.02), 1.0);
}

TEST(BackEnd, WhatTurnsOutToBeTheRobotLeavesMapAndReference) {
  Session session(test::furnishedRoom());
  const auto look = [&](int step, const BodyShape& known) {
    Keyframe keyframe = session.drive.at({0.2 * step, 0.0, 0.0}, kSharp);
    if (known.degrees() == 0) keyframe.storage[static_cast<std::size_t>(keyframe.size++)] = {.x = -0.3F, .y = 0.0F};
    keyframe.body = known;
    keyframe.body_margin = 0.1;
    session.add(keyframe);
    return session.back_end->mapScans(keyframe);
  };
  EXPECT_EQ(look(0, {}).size(), 1U);
  const auto second = look(1, {});
  ASSERT_EQ(second.size(), 1U);
  EXPECT_FALSE(session.correction);
  BodyShape casing;
  casing.millimetres[180] = 300;
  const auto third = look(2, casing);
  ASSERT_EQ(third.size(), 3U) << "all are to be drawn";
  EXPECT_EQ(third[1].id, 1);
  EXPECT_EQ(third[1].scan->points.size(), second[0].scan->points.size() - 1);
  EXPECT_EQ(session.inReference(), (std::set<int>{0, 1, 2}));
  ASSERT_TRUE(session.correction);
  session.correction.reset();
  EXPECT_EQ(look(3, casing).size(), 1U);
  EXPECT_FALSE(session.correction) << "once";
}

TEST(BackEnd, WhatTurnsOutToBeTheRobotWhileNothingIsDrawnLeavesTheMapLater) {
  Session session(test::furnishedRoom());
  BodyShape casing;
  casing.millimetres[180] = 300;
  constexpr double kSpacing = 0.26;  // [m] no whole number of them is the way after which a map is extended
  std::vector<std::size_t> drawn;    // scans a keyframe
  std::set<int> since_given;         // ids
  for (int i = 0; i <= kVisit; ++i) {
    Keyframe keyframe = session.drive.at(kStart * Pose2{kSpacing * i, 0.0, 0.0}, {}, kSharp);
    keyframe.body_margin = 0.1;
    if (i < 2) {
      keyframe.storage[static_cast<std::size_t>(keyframe.size++)] = {.x = -0.3F, .y = 0.0F};
    } else {
      keyframe.body = casing;
      keyframe.session = 1;
    }
    if (i == 2) keyframe.origin = KeyframeOrigin::kGiven;
    session.add(keyframe);
    const auto scans = session.back_end->mapScans(keyframe);
    drawn.push_back(scans.size());
    for (const MapScan& scan : scans) {
      if (i >= 2) since_given.insert(scan.id);
    }
  }
  ASSERT_EQ(drawn[2], 0U) << "the place that was given is not part of the map yet";
  ASSERT_EQ(drawn.back(), 1U);
  EXPECT_TRUE(since_given.contains(0));
  EXPECT_TRUE(since_given.contains(1));
  EXPECT_EQ(since_given.size(), static_cast<std::size_t>(kVisit + 1));
}

}  // namespace
}  // namespace slam::back_end_test
