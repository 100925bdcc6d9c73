// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/tracking_state.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "frontend/drive.hpp"
#include "support/allocations.hpp"

namespace slam::tracking_state_test {
namespace {

using namespace std::chrono_literals;
using test::Drive;
using test::kCurve;
using test::kSpin;
using test::kStand;

TEST(TrackingState, IsDegradedWithoutLidarAndLocalisedAgainWithIt) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(4.0, kCurve);
  drive.lidar.there = false;
  drive.run(3.0, kCurve);
  EXPECT_EQ(drive.state(), LocalisationState::kDegraded);
  EXPECT_LT(drive.error(), 0.15);
  drive.lidar.there = true;
  drive.run(2.0, kCurve);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_LT(drive.error(), 0.04);
}

TEST(TrackingState, IsLostWithinASecondOnceNoSensorGivesTheMotion) {
  for (const bool moving : {false, true}) {
    Drive drive;
    drive.run(4.0, moving ? kCurve : kStand);
    const Timestamp away = drive.now;
    const auto after = [&](double seconds) { return drive.front_end->estimate(away + fromSeconds(seconds)); };
    EXPECT_EQ(after(0.9).state, LocalisationState::kLocalised);
    for (const double seconds : {1.1, 10.0, 300.0}) {
      EXPECT_EQ(after(seconds).state, LocalisationState::kLost) << seconds;
      EXPECT_TRUE(drive.front_end->trackingReport(away + fromSeconds(seconds)).silent);
    }
    const double reach = drive.front_end->config().ekf.limits.max_speed * 300.0;
    EXPECT_NEAR(std::sqrt(after(300.0).covariance(0, 0)), reach, 0.1 * reach) << "it may have driven all the time";
  }
}

TEST(TrackingState, IsAPoseAgainOnceAnySensorGivesTheMotionAndAScanMatches) {
  Drive drive;
  drive.run(4.0, kStand);
  drive.now += 60s;
  EXPECT_EQ(drive.state(), LocalisationState::kLost);
  drive.lidar.there = false;
  drive.wheels.there = false;
  drive.run(0.5, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kLost) << "a gyro does not tell how far it was carried";
  drive.lidar.there = true;
  drive.wheels.there = true;
  drive.run(1.0, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_LT(drive.error(), 0.03);
}

TEST(TrackingState, IsInitialisingUntilAScanIsPlaced) {
  Drive drive;
  drive.lidar.there = false;
  drive.run(2.0, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kInitialising);
}

TEST(TrackingState, AFastLidarIsNotLostBehindADoorSill) {
  Drive drive;
  drive.lidar.every = 1;  // 50 Hz
  drive.run(4.0, {0.3, 0, 0.1});
  drive.enter(test::Room{.length = 1.1, .width = 0.9});  // legs all around
  drive.run(0.5, {0.3, 0, 0.1});
  EXPECT_NE(drive.state(), LocalisationState::kLost);
  drive.enter(test::Room{.length = 8.0, .width = 5.0});
  drive.run(1.0, {0.3, 0, 0.1});
  EXPECT_EQ(drive.front_end->counters().lost, 0U);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_LT(drive.error(), 0.05);
}

MatchResult matched(double overlap) {
  MatchResult match;
  match.status = MatchStatus::kConverged;
  match.observable = 3;
  match.overlap = overlap;
  return match;
}

TEST(TrackingState, MustActAfterManyFailuresThatLast) {
  const TrackingConfig config;  // 8 failures, 1 s
  TrackingState tracking(config, false, false);
  Timestamp now{100s};
  tracking.begin(now, {}, {});
  EXPECT_EQ(tracking.state(now, now, Eigen::Matrix3d::Zero()), LocalisationState::kLocalised);
  const MatchResult none;
  for (int i = 0; i < 8; ++i) EXPECT_FALSE(tracking.fail(none, now += 200ms, true, true)) << i;
  EXPECT_FALSE(tracking.fail(none, now, false, true)) << "a scan that says nothing is no failure";
  EXPECT_EQ(tracking.failures(), 8);
  EXPECT_FALSE(tracking.fail(none, now, true, false)) << "nobody could take a keyframe";
  EXPECT_TRUE(tracking.fail(none, now, true, true));
  EXPECT_EQ(tracking.failures(), 0);

  tracking.follow(matched(0.9), now, {}, {});
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(tracking.fail(none, now += 40ms, true, true)) << "a fast lidar fails often";
  EXPECT_TRUE(tracking.fail(none, now += 300ms, true, true));
}

TEST(TrackingState, KeepsTheLastMatchAndTheMotionToIt) {
  TrackingState tracking({}, false, false);
  const Timestamp now{100s};
  const Pose2 first{1.0, 2.0, 0.3}, motion{0.1, 0.02, 0.05}, T_new_old{3.0, -1.0, 0.7};
  tracking.begin(now, first, {5.0, 0.0, 0.0});
  tracking.follow(matched(0.8), now + 200ms, first * motion, {5.1, 0.0, 0.0});
  tracking.fail(matched(0.3), now + 400ms, true, true);
  EXPECT_EQ(tracking.overlap(), 0.3);
  EXPECT_EQ(tracking.fusedOverlap(), 0.8);
  EXPECT_NEAR(tracking.lastMotion().x, motion.x, 1e-12);
  EXPECT_EQ(tracking.lastOdometry(), (Pose2{5.1, 0.0, 0.0}));
  tracking.transform(T_new_old);
  EXPECT_EQ(tracking.lastPose(), T_new_old * (first * motion));
  EXPECT_NEAR(tracking.lastMotion().x, motion.x, 1e-12) << "the map moved, not the robot";
}

TEST(TrackingState, OnlyALocalisedPoseIsDegradedByAContradiction) {
  const Timestamp now{100s};
  const Eigen::Matrix3d sure = Eigen::Matrix3d::Zero();
  TrackingState tracking({}, false, false);
  tracking.begin(now, {}, {});
  EXPECT_EQ(tracking.state(now, now, sure), LocalisationState::kLocalised);
  EXPECT_EQ(tracking.state(now, now, sure, true), LocalisationState::kDegraded);
  tracking.refute();
  EXPECT_EQ(tracking.state(now, now, sure, true), LocalisationState::kLost);
}

TEST(TrackingState, ARobotIsLostWhoseWayIsTooUncertainOrWhoseMapHasNoOutside) {
  const TrackingConfig config;  // sigma 1 m
  const Eigen::Matrix3d sure = 0.01 * Eigen::Matrix3d::Identity();
  EXPECT_FALSE(TrackingState(config, false, false).lost(sure));
  EXPECT_TRUE(TrackingState(config, false, false).lost(1.1 * Eigen::Matrix3d::Identity()));
  EXPECT_TRUE(TrackingState(config, false, true).lost(sure)) << "it was not found yet";
  EXPECT_TRUE(TrackingState(config, true, false).lost(sure));
}

TEST(TrackingState, IsLostOnlyOnceItHadBeenPlaced) {
  TrackingState tracking({}, false, true);
  const Timestamp now{100s};
  const Eigen::Matrix3d sure = Eigen::Matrix3d::Zero();
  EXPECT_EQ(tracking.state(now, now, sure), LocalisationState::kInitialising);
  tracking.begin(now, {}, {});
  EXPECT_EQ(tracking.state(now, now, sure), LocalisationState::kInitialising) << "in a known map, and not found in it";
  tracking.place();
  EXPECT_EQ(tracking.state(now, now, sure), LocalisationState::kLocalised);
  EXPECT_EQ(tracking.state(now, now, 1.1 * Eigen::Matrix3d::Identity()), LocalisationState::kLost);
  EXPECT_EQ(tracking.state(now, now - 900ms, sure), LocalisationState::kLocalised);
  EXPECT_EQ(tracking.state(now, now - 1100ms, sure), LocalisationState::kLost) << "no sensor tells the motion";
  tracking.beginSession(TrackingState::Place::kNoMore);
  EXPECT_EQ(tracking.state(now, now, sure), LocalisationState::kLost);
  tracking.beginSession(TrackingState::Place::kKnown);
  EXPECT_EQ(tracking.state(now, now, sure), LocalisationState::kLocalised) << "a person said where it is";
  tracking.beginSession(TrackingState::Place::kAssumed);
  EXPECT_EQ(tracking.state(now, now, sure), LocalisationState::kDegraded) << "it may be on another floor";
  EXPECT_TRUE(tracking.placed() && tracking.assumed());
  tracking.place();
  EXPECT_EQ(tracking.state(now, now, sure), LocalisationState::kLocalised);
  tracking.refute();
  EXPECT_EQ(tracking.state(now, now, sure), LocalisationState::kLost);
}

}  // namespace
}  // namespace slam::tracking_state_test
