// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/motion_selection.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "tools/calibrate/motions.hpp"

namespace slam::motion_selection_test {
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
  std::erase_if(no_wheels.wheels, [](const AccumulatedAngles& w) { return w.stamp > at(5.0) && w.stamp < at(15.0); });
  for (const SensorLog& log : {no_scans, no_wheels}) {
    const auto motions = selectMotions(log, kRobot);
    EXPECT_LT(motions.size(), 0.6 * static_cast<double>(all));
    EXPECT_GT(motions.size(), 0.3 * static_cast<double>(all));
    expectExact(motions);
  }
}

TEST(MotionSelection, LeavesOutWhereTheCountersBeganAnew) {
  SensorLog log = arc(20.0);
  for (AccumulatedAngles& reading : log.wheels) {
    if (reading.stamp > at(10.0)) reading.left -= 70.0, reading.right -= 90.0;
  }
  const auto motions = selectMotions(log, kRobot);
  EXPECT_GE(motions.size(), 10U);
  expectExact(motions);
}

TEST(MotionSelection, LeavesOutStandingAndWhatTheWheelsDoNotCover) {
  SensorLog standing = arc(20.0);
  for (AccumulatedAngles& reading : standing.wheels) reading.left = reading.right = 0.0;
  EXPECT_TRUE(selectMotions(standing, kRobot).empty());
  SensorLog late = arc(20.0);
  std::erase_if(late.wheels, [](const AccumulatedAngles& w) { return w.stamp > at(3.0); });
  EXPECT_LE(selectMotions(late, kRobot).size(), 3U);
  EXPECT_TRUE(selectMotions({}, kRobot).empty());
}

TEST(MotionSelection, TakesTheScansErrorsAlongTheLeverOfTheLidar) {
  SensorLog log = arc(5.0);
  Eigen::Matrix3d first, second;  // skewed, and others at each scan
  first << 4e-6, 1e-6, 2e-6, 1e-6, 9e-6, -3e-6, 2e-6, -3e-6, 16e-6;
  second << 25e-6, -8e-6, 3e-6, -8e-6, 6e-6, 2e-6, 3e-6, 2e-6, 2e-6;
  for (std::size_t i = 0; i < log.scans.size(); ++i) log.scans[i].covariance = i == 0 ? first : second;
  RobotGeometry robot = kRobot;
  const auto motions = selectMotions(log, robot);
  ASSERT_FALSE(motions.empty());
  const MatchedScan& begin = log.scans[0];
  const auto end = std::find_if(log.scans.begin() + 1, log.scans.end(), [&](const MatchedScan& scan) {
    const Pose2 moved = between(begin.T_map_base * robot.T_base_lidar, scan.T_map_base * robot.T_base_lidar);
    return (moved.vector() - motions[0].T_begin_end.vector()).norm() < 1e-9;
  });
  ASSERT_NE(end, log.scans.end());
  // Of each coordinate by a small step: x, y in map, the turn on the spot.
  constexpr double kTiny = 1e-6;
  const auto motionOf = [&](const Pose2& a, const Pose2& b) {
    return between(a * robot.T_base_lidar, b * robot.T_base_lidar).vector();
  };
  Eigen::Matrix3d J_begin, J_end;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kTiny * Eigen::Vector3d::Unit(i);
    const Pose2 &a = begin.T_map_base, &b = end->T_map_base;
    J_begin.col(i) =
        (motionOf(Pose2::fromVector(a.vector() + step), b) - motionOf(Pose2::fromVector(a.vector() - step), b)) /
        (2.0 * kTiny);
    J_end.col(i) =
        (motionOf(a, Pose2::fromVector(b.vector() + step)) - motionOf(a, Pose2::fromVector(b.vector() - step))) /
        (2.0 * kTiny);
  }
  const Eigen::Matrix3d expected = J_begin * first * J_begin.transpose() + J_end * second * J_end.transpose();
  EXPECT_TRUE(motions[0].covariance.isApprox(expected, 1e-5)) << motions[0].covariance << "\n\n" << expected;
}

TEST(MotionSelection, EndsAMotionWhereItHasGoneFarEnoughAndGivesUpSlowOnes) {
  const MotionConfig config;
  SensorLog log = arc(20.0);
  for (const LidarMotion& motion : selectMotions(log, kRobot)) {
    // One scan before the last one neither the way nor the turn was enough.
    const double step = kScanPeriod * (kLeftRate * kRobot.left_radius + kRightRate * kRobot.right_radius) / 2.0;
    const Pose2 moved = predictPose(kRobot, motion.wheels);
    EXPECT_TRUE(moved.translation().norm() >= config.translation || std::abs(moved.theta) >= config.rotation);
    EXPECT_LT(moved.translation().norm(), config.translation + 1.5 * step);
  }
  // At a tenth of the speed a motion takes longer than it may.
  for (AccumulatedAngles& reading : log.wheels) reading.left /= 10.0, reading.right /= 10.0;
  EXPECT_TRUE(selectMotions(log, kRobot).empty());
}

TEST(MotionSelection, EndsAMotionWhereItHasTurnedEnough) {
  MotionConfig config;
  config.translation = 10.0;
  const auto motions = selectMotions(arc(20.0), kRobot, config);
  EXPECT_GE(motions.size(), 8U);
  const double step = kScanPeriod * (kRightRate * kRobot.right_radius - kLeftRate * kRobot.left_radius) / kRobot.track;
  for (const LidarMotion& motion : motions) {
    EXPECT_GE(motion.T_begin_end.theta, config.rotation);
    EXPECT_LT(motion.T_begin_end.theta, config.rotation + 1.5 * step);
  }
}

TEST(MotionSelection, GoesOverNoGapOfMoreThanASecond) {
  const auto motionsOf = [](double gap) {
    SensorLog log = arc(20.0);
    std::vector<MatchedScan> kept{log.scans.front()};
    for (const MatchedScan& scan : log.scans) {
      if (toSeconds(scan.stamp - kept.back().stamp) > gap - 0.01) kept.push_back(scan);
    }
    log.scans = kept;
    return selectMotions(log, kRobot).size();
  };
  EXPECT_GE(motionsOf(5 * kScanPeriod), 6U);
  EXPECT_EQ(motionsOf(6 * kScanPeriod), 0U) << "each is a gap";
}

}  // namespace
}  // namespace slam::motion_selection_test
