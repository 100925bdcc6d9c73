// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/registration.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "frontend/drive.hpp"
#include "support/allocations.hpp"

namespace slam::registration_test {
namespace {

using namespace std::chrono_literals;
using test::Drive;
using test::kCurve;
using test::kSpin;
using test::kStand;

TEST(Registration, FollowsAFastSpin) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(6.0, kSpin);
  EXPECT_LT(drive.error(), 0.03);
  EXPECT_LE(drive.front_end->counters().unmatched + drive.front_end->counters().gated,
            3U);  // the jolt at its begin and end
}

TEST(Registration, AcceptsScansWhenTheWheelsSpinOnTheSpot) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.wheels.scale = drive.wheels.turn_scale = 2.0;
  drive.run(5.0, {0.15, 0, 0});
  EXPECT_LT(drive.error(), 0.05);
}

TEST(Registration, TracksScansByThePapersBaselineWhereItIsChosen) {
  FrontEndConfig config;
  config.match.method = MatchMethod::kPointToPoint;
  Drive points(config), lines;
  for (Drive* drive : {&points, &lines}) {
    drive->run(2.0, kStand);
    drive->run(6.0, kCurve);
  }
  EXPECT_LT(points.error(), 0.1);
  EXPECT_GT(points.error(), lines.error());
}

TEST(Registration, FindsItselfAfterTheWheelsPretendedAJump) {
  for (const Pose2 jump : {Pose2{0.5, 0.0, 0.0}, Pose2{-0.3, 0.4, 0.0}, Pose2{0.1, 0.1, 1.0}}) {
    Drive drive;
    drive.gyro.there = false;
    drive.run(2.0, kStand);
    drive.run(4.0, kCurve);
    drive.wheels.leap(jump);
    drive.run(1.0, kCurve);
    EXPECT_LT(drive.error(), 0.05);
    EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  }
}

TEST(Registration, AFailedMatchNeverMovesThePose) {
  Drive drive;
  drive.run(3.0, kStand);
  const Pose2 before = drive.front_end->estimate(drive.now).T_map_base;
  drive.enter(test::Room{.length = 3.0, .width = 2.4});  // the lidar sees something else altogether
  drive.run(1.0, kStand);
  EXPECT_FALSE(drive.last.fused);
  const Pose2 moved = between(before, drive.front_end->estimate(drive.now).T_map_base);
  EXPECT_LT(std::hypot(moved.x, moved.y), 0.005);
  EXPECT_EQ(drive.state(), LocalisationState::kDegraded);
}

}  // namespace
}  // namespace slam::registration_test
