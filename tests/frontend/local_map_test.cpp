// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/local_map.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "frontend/drive.hpp"
#include "support/allocations.hpp"

namespace slam::local_map_test {
namespace {

using namespace std::chrono_literals;
using test::Drive;
using test::kCurve;
using test::kSpin;
using test::kStand;

/// A drive whose map is then corrected as a back end would.
class CorrectedMap : public testing::Test {
 protected:
  explicit CorrectedMap(const FrontEndConfig& config = {}) : drive(config) {
    drive.keyframes = &graph;
    drive.run(2.0, kStand);
    drive.run(8.0, kCurve);
  }
  Pose2 estimate() const { return drive.front_end->estimate(drive.now).T_map_base; }
  /// The keyframes given, all moved alike.
  std::unique_ptr<MapCorrection> corrected(const std::vector<int>& ids, const Pose2& motion) {
    auto correction = std::make_unique<MapCorrection>(drive.front_end->config().reference);
    correction->reference.clear((motion * estimate()).translation());
    for (const int id : ids) {
      graph.points(id, points);
      correction->reference.add(motion * graph.pose(id), points);
      correction->keyframes.push_back({id, motion * graph.pose(id), graph.scan(id)->covariance});
    }
    correction->newest = ids.empty() ? -1 : ids.back();
    return correction;
  }
  std::vector<int> upTo(int newest) const {
    std::vector<int> ids(static_cast<std::size_t>(newest) + 1);
    std::iota(ids.begin(), ids.end(), 0);
    return ids;
  }
  int newest() const { return graph.size() - 1; }
  static double distance(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

  Drive drive;
  KeyframeGraph graph;
  ScanPoints points;
};

const Pose2 kMotion{0.6, -0.4, 0.3};

TEST_F(CorrectedMap, MovesPoseAndKeyframesAsOne) {
  const PoseEstimate before = drive.front_end->estimate(drive.now);
  const AnchoredPose anchored = drive.front_end->anchor(before.T_map_base);
  ASSERT_GE(anchored.keyframe, 0);
  drive.front_end->apply(*corrected(upTo(newest()), kMotion));

  const PoseEstimate after = drive.front_end->estimate(drive.now);
  const Pose2 expected = kMotion * before.T_map_base;
  EXPECT_LT(distance(after.T_map_base, expected), 1e-9);
  EXPECT_NEAR(wrapAngle(after.T_map_base.theta - expected.theta), 0.0, 1e-9);
  EXPECT_NEAR(after.twist.vx, before.twist.vx, 1e-9);
  EXPECT_NEAR(after.covariance.trace(), before.covariance.trace(), 1e-12);
  Eigen::Matrix2d turn;
  turn << std::cos(kMotion.theta), -std::sin(kMotion.theta), std::sin(kMotion.theta), std::cos(kMotion.theta);
  const Eigen::Matrix2d turned = turn * before.covariance.topLeftCorner<2, 2>() * turn.transpose();
  EXPECT_LT((after.covariance.topLeftCorner<2, 2>() - turned).norm(), 1e-6 * turned.norm());

  const AnchoredPose same = drive.front_end->anchor(after.T_map_base);
  EXPECT_EQ(same.keyframe, anchored.keyframe);
  EXPECT_LT(distance(same.T_keyframe_base, anchored.T_keyframe_base), 1e-9);
}

TEST_F(CorrectedMap, GoesOnMatchingInTheCorrectedMap) {
  for (const Pose2& motion : {kMotion, Pose2{-20.0, 35.0, 2.5}, Pose2{}}) {
    drive.front_end->apply(*corrected(upTo(newest()), motion));
    for (int id = 0; id < graph.size(); ++id) graph.graph().setPose(id, motion * graph.pose(id));
    const Pose2 T_map_world = estimate() * drive.truth.inverse();
    const FrontEndCounters before = drive.front_end->counters();
    drive.run(5.0, kCurve);
    EXPECT_LT(distance(estimate(), T_map_world * drive.truth), 0.04);
    EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
    const FrontEndCounters after = drive.front_end->counters();
    EXPECT_GE(after.matched, before.matched + 25);
    EXPECT_EQ(after.unmatched + after.gated + after.searched, before.unmatched + before.gated + before.searched);
  }
}

TEST_F(CorrectedMap, JumpsOnceInMapAndNeverInOdom) {
  const OdometryEstimate before = drive.front_end->odometry(drive.now);
  drive.front_end->apply(*corrected(upTo(newest()), kMotion));
  const OdometryEstimate after = drive.front_end->odometry(drive.now);
  EXPECT_EQ(after.T_odom_base, before.T_odom_base);
  EXPECT_EQ(after.covariance, before.covariance);
  EXPECT_LT(distance(after.T_map_odom, kMotion * before.T_map_odom), 1e-9);
  Pose2 odom = after.T_odom_base, map = estimate();
  for (int step = 0; step < 100; ++step) {
    drive.run(0.02, kCurve);
    const Pose2 next_odom = drive.front_end->odometry(drive.now).T_odom_base, next_map = estimate();
    ASSERT_LT(distance(odom, next_odom), 0.01) << step;
    ASSERT_LT(distance(map, next_map), 0.03) << step;
    odom = next_odom;
    map = next_map;
  }
}

TEST_F(CorrectedMap, MovesLikeTheNearestKeyframe) {
  const auto nearestNow = [&] { return drive.front_end->anchor(estimate()).keyframe; };
  for (int i = 0; i < 100 && nearestNow() == newest(); ++i) drive.run(0.2, kCurve);  // round to the first ones
  auto correction = corrected(upTo(newest()), {});
  const int nearest = nearestNow();
  ASSERT_LT(nearest, newest());
  for (ReferenceKeyframe& keyframe : correction->keyframes) {
    keyframe.T_map_base = (keyframe.id == nearest ? kMotion : Pose2{5.0, 5.0, 1.0}) * keyframe.T_map_base;
  }
  const Pose2 expected = kMotion * estimate();
  drive.front_end->apply(*correction);
  EXPECT_LT(distance(estimate(), expected), 1e-9);
}

TEST_F(CorrectedMap, KeepsKeyframesNewerThanTheCorrection) {
  const Pose2 last = graph.pose(newest());
  const auto surfels = corrected(upTo(newest()), kMotion)->reference.size();
  auto correction = corrected(upTo(newest() - 2), kMotion);
  const auto without = correction->reference.size();
  drive.front_end->apply(*correction);
  for (const int id : {newest() - 1, newest()}) {
    const AnchoredPose there = drive.front_end->anchor(kMotion * graph.pose(id));
    EXPECT_EQ(there.keyframe, id);
    EXPECT_LT(distance(there.T_keyframe_base, {}), 1e-9);
  }
  // Their points are in the reference, too: applied once more, it comes back.
  auto next = corrected(upTo(newest()), kMotion);
  drive.front_end->apply(*next);
  EXPECT_GE(next->reference.size(), without);
  EXPECT_EQ(next->reference.size(), surfels);
  EXPECT_EQ(next->keyframes.size(), static_cast<std::size_t>(graph.size()));

  // The next keyframe's step begins where the moved one lies.
  drive.keyframes = nullptr;
  drive.enter(test::Room{.length = 2.4, .width = 2.0});  // hides all that is known, so one is kept
  const auto known = drive.front_end->counters().keyframes;
  while (drive.front_end->counters().keyframes == known && drive.now < Timestamp{200s}) drive.run(0.18, kCurve);
  ASSERT_NE(drive.last.keyframe, nullptr);
  const Pose2 expected = kMotion * last * drive.last.keyframe->T_previous_base;
  EXPECT_LT(distance(drive.last.keyframe->T_map_base, expected), 1e-9);
}

/// Each scan becomes a keyframe: many come while a correction is computed.
class DenselyKeptMap : public CorrectedMap {
 protected:
  static FrontEndConfig dense() {
    FrontEndConfig config;
    config.keyframe.translation = 0.01;
    config.keyframe.known_ratio = 2.0;  // nothing is
    return config;
  }
  DenselyKeptMap() : CorrectedMap(dense()) { drive.run(8.0, kCurve); }
};

TEST_F(DenselyKeptMap, KeepsSixAndAllThatCanBeAheadOfACorrection) {
  for (const int ahead : {6, MapCorrection::kMostAhead}) {
    ASSERT_GT(newest(), ahead) << "keyframes";
    const auto surfels = corrected(upTo(newest()), kMotion)->reference.size();
    auto correction = corrected(upTo(newest() - ahead), kMotion);
    EXPECT_EQ(test::allocationsDuring([&] { drive.front_end->apply(*correction); }), 0U);
    const auto held = drive.front_end->referenceKeyframes();
    ASSERT_EQ(held.size(), static_cast<std::size_t>(graph.size())) << ahead;
    for (int id = 0; id <= newest(); ++id) {
      const ReferenceKeyframe& keyframe = held[static_cast<std::size_t>(id)];
      EXPECT_EQ(keyframe.id, id) << ahead;
      EXPECT_LT(distance(keyframe.T_map_base, kMotion * graph.pose(id)), 1e-9) << ahead;
      EXPECT_EQ(drive.front_end->anchor(kMotion * graph.pose(id)).keyframe, id) << ahead;
    }
    for (int id = 0; id < graph.size(); ++id) graph.graph().setPose(id, kMotion * graph.pose(id));
    auto next = corrected(upTo(newest()), {});
    drive.front_end->apply(*next);
    EXPECT_EQ(next->reference.size(), surfels) << ahead << ": their points are in the reference, too";
  }
}

TEST_F(DenselyKeptMap, WhatIsAheadHangsOnTheNewestOfTheCorrection) {
  // The back end has bent the map: each of its keyframes is moved otherwise.
  auto correction = corrected(upTo(newest() - 6), {});
  for (ReferenceKeyframe& keyframe : correction->keyframes) {
    keyframe.T_map_base = Pose2{0.001 * keyframe.id, 0.002 * keyframe.id, 0.0003 * keyframe.id} * keyframe.T_map_base;
  }
  const Pose2 T_new_old = correction->keyframes.back().T_map_base * graph.pose(correction->newest).inverse();
  const Pose2 expected = T_new_old * estimate();
  drive.front_end->apply(*correction);
  const auto held = drive.front_end->referenceKeyframes();
  ASSERT_EQ(held.size(), static_cast<std::size_t>(graph.size()));
  for (int id = newest() - 5; id <= newest(); ++id) {
    EXPECT_LT(distance(held[static_cast<std::size_t>(id)].T_map_base, T_new_old * graph.pose(id)), 1e-9);
  }
  EXPECT_LT(distance(estimate(), expected), 1e-9) << "the robot stays where it is among them";
}

TEST_F(CorrectedMap, TakesTheCorrectionForNoDrift) {
  drive.front_end->apply(*corrected(upTo(newest()), {20.0, -30.0, 0.3}));
  drive.keyframes = nullptr;
  const auto known = drive.front_end->counters().keyframes;
  drive.enter(test::Room{.length = 8.0, .width = 6.0});  // one wall looks new, so a keyframe is kept
  while (drive.front_end->counters().keyframes == known && drive.now < Timestamp{200s}) drive.run(0.18, kCurve);
  ASSERT_NE(drive.last.keyframe, nullptr);
  EXPECT_LT(std::sqrt(drive.last.keyframe->step_covariance(0, 0)), 0.03);
}

TEST_F(CorrectedMap, ForgetsKeyframesThatTheCorrectionLeavesOut) {
  ASSERT_GT(newest(), 4);
  drive.front_end->apply(*corrected({newest() - 1, newest()}, {}));
  for (int id = 0; id < newest() - 1; ++id) EXPECT_GE(drive.front_end->anchor(graph.pose(id)).keyframe, newest() - 1);
}

TEST_F(CorrectedMap, StaysWhereItIsWhenNoKeyframeIsCommon) {
  auto correction = corrected(upTo(newest()), kMotion);
  for (ReferenceKeyframe& keyframe : correction->keyframes) keyframe.id += 1000;
  correction->newest += 1000;
  const Pose2 before = estimate();
  drive.front_end->apply(*correction);
  EXPECT_LT(distance(estimate(), before), 1e-9);
}

TEST_F(CorrectedMap, HandsBackTheOldReference) {
  auto correction = corrected(upTo(newest()), kMotion);
  drive.front_end->apply(*correction);
  ASSERT_EQ(correction->keyframes.size(), static_cast<std::size_t>(graph.size()));
  for (const ReferenceKeyframe& keyframe : correction->keyframes)
    EXPECT_LT(distance(keyframe.T_map_base, graph.pose(keyframe.id)), 1e-9);
}

TEST_F(CorrectedMap, DoesNotAllocateForACorrection) {
  auto correction = corrected(upTo(newest() - 2), kMotion);
  drive.keyframes = nullptr;
  EXPECT_EQ(test::allocationsDuring([&] { drive.front_end->apply(*correction); }), 0U);
  const auto known = drive.front_end->counters().keyframes;
  drive.enter(test::Room{.length = 9.0, .width = 6.0});  // all looks new
  EXPECT_EQ(test::allocationsDuring([&] { drive.run(10.0, kCurve); }), 0U);
  EXPECT_GT(drive.front_end->counters().keyframes, known + 3);
}

TEST_F(CorrectedMap, AnchorsAPoseToTheNearestKeyframe) {
  const FrontEnd fresh{FrontEndConfig{}};
  EXPECT_EQ(fresh.anchor({}).keyframe, -1);
  for (int id = 0; id < graph.size(); ++id) {
    const AnchoredPose there = drive.front_end->anchor(graph.pose(id) * Pose2{0.001, 0.002, 0.5});
    EXPECT_EQ(there.keyframe, id);
    EXPECT_LT(distance(there.T_keyframe_base, {0.001, 0.002, 0.0}), 1e-9);
    EXPECT_NEAR(there.T_keyframe_base.theta, 0.5, 1e-9);
  }
}

}  // namespace
}  // namespace slam::local_map_test
