// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/motion_selection.hpp"

#include <gtest/gtest.h>

#include "tools/calibrate/motions.hpp"

namespace slam {
namespace {

using test::kRobot;

constexpr double kWheelPeriod = 0.02, kScanPeriod = 0.18;  // [s]
constexpr double kLeftRate = 7.0, kRightRate = 9.0;        // [rad/s]: about 0.26 m/s and 0.2 rad/s

Timestamp at(double seconds) { return Timestamp(fromSeconds(100.0 + seconds)); }

/// kRobot on an arc, its scans between the wheels' readings. @param matched_as  T_base_lidar that the matcher believed
SensorLog arc(double seconds, const Pose2& matched_as = kRobot.T_base_lidar) {
  SensorLog log;
  for (double t = 0.0; t < seconds; t += kWheelPeriod) log.wheels.push_back({at(t), kLeftRate * t, kRightRate * t});
  const Pose2 T_world_start{1.0, 2.0, 0.5};
  for (double t = 0.013; t < seconds - kWheelPeriod; t += kScanPeriod) {
    const WheelStep turned{kLeftRate * t, kRightRate * t};
    const Pose2 T_map_lidar = T_world_start * predictPose(kRobot, std::span(&turned, 1));
    log.scans.push_back({at(t), T_map_lidar * matched_as.inverse(), 1e-6 * Eigen::Matrix3d::Identity()});
  }
  return log;
}

void expectExact(const std::vector<LidarMotion>& motions) {
  for (const LidarMotion& motion : motions) {
    EXPECT_LT((motion.T_begin_end.vector() - predictPose(kRobot, motion.wheels).vector()).norm(), 1e-9);
  }
}

TEST(MotionSelection, TakesTheWheelsOverExactlyTheTimeBetweenTheScans) {
  const auto motions = selectMotions(arc(20.0), kRobot);
  EXPECT_GE(motions.size(), 12U);
  EXPECT_LE(motions.size(), 18U);
  expectExact(motions);
}

TEST(MotionSelection, GivesTheLidarsMotionWhateverPlaceWasConfigured) {
  RobotGeometry believed = kRobot;
  believed.T_base_lidar = {-0.3, 0.2, 1.0};
  const auto motions = selectMotions(arc(20.0, believed.T_base_lidar), believed);
  EXPECT_GE(motions.size(), 12U);
  expectExact(motions);
}

TEST(MotionSelection, AddsTheCovariancesOfBothScans) {
  SensorLog log = arc(5.0, {});
  RobotGeometry robot = kRobot;
  robot.T_base_lidar = {};
  const auto motions = selectMotions(log, robot);
  ASSERT_FALSE(motions.empty());
  EXPECT_NEAR(motions[0].covariance(2, 2), 2e-6, 1e-12);
  EXPECT_NEAR(motions[0].covariance(0, 0), 2e-6, 0.2e-6);
}

TEST(MotionSelection, LeavesOutWhereScansOrReadingsAreMissing) {
  const std::size_t all = selectMotions(arc(20.0), kRobot).size();
  SensorLog no_scans = arc(20.0);
  std::erase_if(no_scans.scans, [](const MatchedScan& s) { return s.stamp > at(5.0) && s.stamp < at(15.0); });
  SensorLog no_wheels = arc(20.0);
  std::erase_if(no_wheels.wheels, [](const WheelAngles& w) { return w.stamp > at(5.0) && w.stamp < at(15.0); });
  for (const SensorLog& log : {no_scans, no_wheels}) {
    const auto motions = selectMotions(log, kRobot);
    EXPECT_LT(motions.size(), 0.6 * static_cast<double>(all));
    EXPECT_GT(motions.size(), 0.3 * static_cast<double>(all));
    expectExact(motions);
  }
}

TEST(MotionSelection, LeavesOutWhereTheCountersBeganAnew) {
  SensorLog log = arc(20.0);
  for (WheelAngles& reading : log.wheels) {
    if (reading.stamp > at(10.0)) reading.left -= 70.0, reading.right -= 90.0;
  }
  const auto motions = selectMotions(log, kRobot);
  EXPECT_GE(motions.size(), 10U);
  expectExact(motions);
}

TEST(MotionSelection, LeavesOutStandingAndWhatTheWheelsDoNotCover) {
  SensorLog standing = arc(20.0);
  for (WheelAngles& reading : standing.wheels) reading.left = reading.right = 0.0;
  EXPECT_TRUE(selectMotions(standing, kRobot).empty());
  SensorLog late = arc(20.0);
  std::erase_if(late.wheels, [](const WheelAngles& w) { return w.stamp > at(3.0); });
  EXPECT_LE(selectMotions(late, kRobot).size(), 3U);
  EXPECT_TRUE(selectMotions({}, kRobot).empty());
}

}  // namespace
}  // namespace slam
