// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/closed_form.hpp"

#include <gtest/gtest.h>

#include "tools/calibrate/motions.hpp"

namespace slam::closed_form_test {
namespace {

using test::Drive;
using test::kRobot;

TEST(ClosedForm, FindsTheGeometryFromNoisyMotions) {
  const auto geometry = solveClosedForm(test::MotionMaker(1).make(Drive::kVaried, 100));
  ASSERT_TRUE(geometry);
  EXPECT_NEAR(geometry->left_radius, kRobot.left_radius, 1e-4);
  EXPECT_NEAR(geometry->right_radius, kRobot.right_radius, 1e-4);
  EXPECT_NEAR(geometry->track, kRobot.track, 2e-3);
  EXPECT_NEAR(geometry->T_base_lidar.x, kRobot.T_base_lidar.x, 4e-3);
  EXPECT_NEAR(geometry->T_base_lidar.y, kRobot.T_base_lidar.y, 4e-3);
  EXPECT_NEAR(geometry->T_base_lidar.theta, kRobot.T_base_lidar.theta, 4e-3);
}

TEST(ClosedForm, IsExactWithoutNoise) {
  const auto geometry = solveClosedForm(test::MotionMaker(1, 0.0).make(Drive::kVaried, 10));
  ASSERT_TRUE(geometry);
  EXPECT_TRUE(geometry->vector().isApprox(kRobot.vector(), 1e-9)) << geometry->vector().transpose();
}

TEST(ClosedForm, NeedsNoGuessForALidarThatLooksBackwards) {
  RobotGeometry robot = kRobot;
  robot.T_base_lidar = {-0.2, 0.05, 3.0};
  auto motions = test::MotionMaker(1, 0.0).make(Drive::kVaried, 10);
  for (LidarMotion& motion : motions) motion.T_begin_end = predictPose(robot, motion.wheels);
  const auto geometry = solveClosedForm(motions);
  ASSERT_TRUE(geometry);
  EXPECT_TRUE(geometry->vector().isApprox(robot.vector(), 1e-9)) << geometry->vector().transpose();
}

TEST(ClosedForm, RefusesMotionsThatAreAllAlike) {
  for (const Drive drive : {Drive::kStraight, Drive::kOnTheSpot, Drive::kOneArc}) {
    EXPECT_FALSE(solveClosedForm(test::MotionMaker(1, 0.0).make(drive, 20))) << static_cast<int>(drive);
  }
  EXPECT_FALSE(solveClosedForm({}));
}

TEST(ClosedForm, WeighsMotionsByTheirCovariances) {
  auto motions = test::MotionMaker(1).make(Drive::kVaried, 60);
  auto worse = test::MotionMaker(2, 30.0).make(Drive::kVaried, 60);
  for (LidarMotion& motion : worse) motion.covariance *= 900.0;
  motions.insert(motions.end(), worse.begin(), worse.end());
  const auto geometry = solveClosedForm(motions);
  ASSERT_TRUE(geometry);
  EXPECT_NEAR(geometry->left_radius, kRobot.left_radius, 1e-4);
  EXPECT_NEAR(geometry->right_radius, kRobot.right_radius, 1e-4);
  EXPECT_NEAR(geometry->track, kRobot.track, 2e-3);
  EXPECT_NEAR(geometry->T_base_lidar.x, kRobot.T_base_lidar.x, 4e-3);
  EXPECT_NEAR(geometry->T_base_lidar.y, kRobot.T_base_lidar.y, 4e-3);
}

}  // namespace
}  // namespace slam::closed_form_test
