// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/front_end.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "core/plausibility.hpp"
#include "frontend/drive.hpp"
#include "frontend/place_drive.hpp"
#include "matching/places.hpp"
#include "support/allocations.hpp"

namespace slam::front_end_test {
namespace {

using namespace std::chrono_literals;
using test::Drive;
using test::kCurve;
using test::kSpin;
using test::kStand;

TEST(FrontEnd, FollowsACurveUnderNoiseAndLearnsTheGyroBias) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(20.0, kCurve);
  EXPECT_LT(drive.error(), 0.03);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_NEAR(drive.front_end->odometry(drive.now).gyro_bias, 0.01, 0.002);
  EXPECT_GT(drive.front_end->counters().keyframes, 3U);
}

TEST(FrontEnd, OdometryUsesTheBiasFromScansAndNeverJumps) {
  Drive drive;
  drive.gyro.bias = 0.06;
  Pose2 odom = drive.front_end->odometry(drive.now).T_odom_base, truth = drive.truth;
  double farthest = 0.0, most_turned = 0.0;
  const auto go = [&](double seconds, const Eigen::Vector3d& twist) {
    for (double t = 0.0; t < seconds; t += 0.1) {
      drive.run(0.1, twist);
      const Pose2 now = drive.front_end->odometry(drive.now).T_odom_base;
      const Pose2 step = between(odom, now), driven = between(truth, drive.truth);
      farthest = std::max(farthest, (step.translation() - driven.translation()).norm());
      most_turned = std::max(most_turned, std::abs(wrapAngle(step.theta - driven.theta)));
      odom = now;
      truth = drive.truth;
    }
  };
  go(20.0, kCurve);  // it has never stood still
  EXPECT_NEAR(drive.front_end->odometry(drive.now).gyro_bias, 0.06, 0.003);
  const Pose2 begin = odom, true_begin = truth;
  go(20.0, kCurve);
  EXPECT_NEAR(wrapAngle(between(begin, odom).theta - between(true_begin, truth).theta), 0.0, 0.03);
  go(2.0, kStand);
  EXPECT_LT(farthest, 0.03);
  EXPECT_LT(most_turned, 0.02);
}

TEST(FrontEnd, WorksWithScansAlone) {
  Drive drive;
  drive.wheels.there = drive.gyro.there = false;
  drive.run(1.0, kStand);
  drive.run(15.0, {0.2, 0, 0.2});
  EXPECT_LT(drive.error(), 0.05);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
}

TEST(FrontEnd, WithoutAGyroAHeadingIsLessSureWhileItTurns) {
  const auto variance = [](bool gyro, const Eigen::Vector3d& twist) {
    Drive drive;
    drive.gyro.there = gyro;
    drive.run(2.0, kStand);
    drive.run(5.0, twist);
    return drive.front_end->estimate(drive.now).covariance(2, 2);
  };
  const double turned = 0.5 * kCurve.z() * 0.18;  // [rad] in half a scan
  EXPECT_GT(variance(false, kCurve), EkfConfig{}.wheelRotationVariance(0.0, turned));
  EXPECT_LT(variance(false, kStand), 1e-4);
  EXPECT_LT(variance(true, kCurve), 1e-4);
}

TEST(FrontEnd, OutweighsWheelsThatKeepLying) {
  Drive drive;
  drive.gyro.there = false;
  drive.run(2.0, kStand);
  drive.wheels.scale = drive.wheels.turn_scale = -1.0;  // forwards is reported as backwards
  drive.run(10.0, kCurve);
  EXPECT_LT(drive.error(), 0.12);  // the wheels carry the pose astray for up to 180 ms after a scan
  EXPECT_TRUE(drive.last.fused);
}

TEST(FrontEnd, LeavesWrongWheelsOutUntilTheyAreRightAgain) {
  for (const bool imu : {true, false}) {
    Drive drive;
    drive.gyro.there = imu;
    drive.run(2.0, kStand);
    drive.wheels.scale = drive.wheels.turn_scale = -1.0;
    drive.run(30.0, kCurve);
    EXPECT_EQ(drive.front_end->counters().wheels_rejected, 1U);
    EXPECT_LT(drive.error(), 0.06);  // of a lidar alone, up to 180 ms after a scan
    drive.wheels.scale = drive.wheels.turn_scale = 1.0;
    drive.run(60.0, kCurve);
    EXPECT_LT(drive.error(), 0.03);
    drive.lidar.there = false;
    drive.run(2.0, kCurve);
    EXPECT_LT(drive.error(), 0.1) << "the wheels are not heard again";
    EXPECT_EQ(drive.front_end->counters().wheels_rejected, 1U);
  }
}

TEST(FrontEnd, AfterTheLastScanItDrivesByWheelsThatScansContradicted) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.wheels.scale = drive.wheels.turn_scale = -1.0;
  drive.run(30.0, kCurve);
  ASSERT_EQ(drive.front_end->counters().wheels_rejected, 1U);
  drive.lidar.there = false;
  drive.wheels.scale = drive.wheels.turn_scale = 1.0;
  drive.run(2.0, kCurve);
  const double at_the_end = drive.error();
  drive.run(30.0, kStand);
  EXPECT_LT(drive.error(), at_the_end + 0.05) << "without wheels it would go on at the last speed for ever";
  EXPECT_LT(drive.front_end->estimate(drive.now).twist.vx, 0.01);
}

TEST(FrontEnd, RangesThatScatterAtRestLeaveTheWayToWheelsAndGyro) {
  Drive drive;
  drive.lidar.range_sigma = 0.3;
  drive.run(3.0, kStand);
  EXPECT_NEAR(drive.front_end->trackingReport(drive.now).range_noise, 0.3, 0.1);
  for (int i = 0; i < 10; ++i) {
    drive.run(6.0, kCurve);
    const Pose2 odom = drive.front_end->odometry(drive.now).T_odom_base;
    EXPECT_LT((drive.front_end->estimate(drive.now).T_map_base.translation() - odom.translation()).norm(), 0.05);
    EXPECT_EQ(drive.state(), LocalisationState::kDegraded);
  }
}

TEST(FrontEnd, APlaceThatIsNotKnownAlongACorridorIsLookedForThoughScansMatch) {
  test::PlaceDrive drive(test::endlessCorridor());
  const Eigen::Vector3d ahead(0.5, 0.0, 0.0);
  drive.run(3.0, kStand);
  drive.run(6.0, ahead);
  EXPECT_EQ(drive.front_end->counters().lost, 0U);
  drive.wheels.scale = 0.0;  // their counters die
  for (double seconds = 0.0; seconds < 30.0 && drive.front_end->counters().lost == 0; seconds += 1.0) {
    drive.run(1.0, ahead);
    EXPECT_FALSE(drive.front_end->wheelsDead()) << "nothing along the corridor shows it";
  }
  EXPECT_EQ(drive.front_end->counters().lost, 1U);
  EXPECT_FALSE(drive.front_end->placed());
}

TEST(FrontEnd, WheelsAreNotLeftOutForScansThatWereNoise) {
  double least = 1e9, most = 0.0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Drive drive;
    drive.random.seed(seed);
    drive.run(2.0, kStand);
    drive.lidar.range_sigma = 0.3;
    drive.run(4.0, kCurve);
    drive.run(0.04, 0.3 * kCurve);  // it brakes as tyres can
    drive.run(3.0, kStand);
    ASSERT_GT(drive.front_end->trackingReport(drive.now).range_noise, 0.0);
    drive.run(20.0, kCurve);
    const double sigma = std::sqrt(drive.front_end->estimate(drive.now).covariance(0, 0));
    least = std::min(least, sigma);
    most = std::max(most, sigma);
  }
  EXPECT_LT(most, 1.3 * least) << least << " m, whatever the scans before had contradicted";
}

TEST(FrontEnd, CorrectsWheelsOfAWrongRadius) {
  for (const double factor : {0.75, 1.2, 1.5}) {
    Drive drive;
    drive.wheels.scale = drive.wheels.turn_scale = factor;
    drive.run(2.0, kStand);
    drive.run(20.0, kCurve);
    EXPECT_NEAR(drive.front_end->counters().wheels_scale, factor, 0.03 * factor);
    EXPECT_EQ(drive.front_end->counters().wheels_rejected, 0U) << factor;
    drive.lidar.there = false;
    drive.run(8.0, kCurve);
    EXPECT_LT(drive.error(), 0.1) << factor;
  }
}

TEST(FrontEnd, WheelsThatFellSilentAreNotEvaluatedMeanwhile) {
  for (const bool imu : {true, false}) {
    Drive drive;
    drive.gyro.there = imu;
    drive.run(2.0, kStand);
    drive.wheels.there = false;
    drive.run(20.0, kCurve);
    EXPECT_LT(drive.error(), 0.06) << "of a lidar alone";
    EXPECT_NEAR(drive.front_end->counters().wheels_scale, 1.0, 0.02);
    EXPECT_EQ(drive.front_end->counters().wheels_rejected, 0U);
    drive.wheels.there = true;
    drive.run(4.0, kCurve);
    EXPECT_NEAR(drive.front_end->counters().wheels_scale, 1.0, 0.05);
    drive.lidar.there = false;
    drive.run(4.0, kCurve);
    EXPECT_LT(drive.error(), 0.1);
  }
}

/// Two lidars that are merged: what the rear one sees is turned by 5 deg, for it is mounted so.
TEST(FrontEnd, AScanWhoseHalvesContradictEachOtherDoesNotLead) {
  for (const bool judged : {true, false}) {
    FrontEndConfig config;
    if (!judged) config.heading_monitor.contradiction = 1e9;
    Drive drive(config);
    drive.enter(test::hallWithPillars());
    drive.rearrange = [](LaserScan& scan) {
      for (Beam& beam : std::span(scan.storage).first(static_cast<std::size_t>(scan.size)))
        if (std::abs(wrapAngle(beam.bearing)) > 1.6) beam.bearing += 0.087F;
    };
    drive.run(2.0, kStand);
    for (int lap = 0; lap < 10; ++lap) {
      drive.run(10.0, {0.4, 0.0, 0.0});
      drive.run(1.5, {0.0, 0.0, std::numbers::pi / 3.0});
    }
    const double turned = std::abs(between(drive.truth, drive.front_end->estimate(drive.now).T_map_base).theta);
    if (judged) {
      EXPECT_EQ(drive.state(), LocalisationState::kDegraded);
      EXPECT_LT(turned, 0.05);
      EXPECT_LT(drive.error(), 0.3);
    } else {
      EXPECT_GT(turned, 0.1);
    }
    EXPECT_EQ(drive.front_end->trackingReport(drive.now).scan_drift != 0.0, judged);
  }
}

TEST(FrontEnd, JoinsOdomAndMap) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(5.0, kCurve);
  const OdometryEstimate odometry = drive.front_end->odometry(drive.now);
  const Pose2 joined = odometry.T_map_odom * odometry.T_odom_base;
  const Pose2 error = between(drive.front_end->estimate(drive.now).T_map_base, joined);
  EXPECT_LT(std::hypot(error.x, error.y), 1e-9);
}

TEST(FrontEnd, BeyondWhereAMapReachesTheRobotIsLostAndBeginsAtTheOrigin) {
  KeyframeGraph keyframes;
  Drive drive;
  drive.keyframes = &keyframes;
  drive.run(1.0, kStand);
  drive.front_end->setPose({9999.5, -9000.0, 0.0}, {0.2, 0.2, 0.1});
  drive.run(1.0, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_EQ(drive.front_end->counters().far_off, 0U);
  drive.run(4.0, {0.3, 0, 0});
  EXPECT_EQ(drive.front_end->counters().far_off, 1U);
  EXPECT_EQ(drive.state(), LocalisationState::kLost);
  const Pose2 pose = drive.front_end->estimate(drive.now).T_map_base;
  EXPECT_LT(std::hypot(pose.x, pose.y), 2.0);
  EXPECT_NEAR(pose.theta, 0.0, 0.1) << "the gyro still knows";
  EXPECT_TRUE(drive.last.fused) << "it goes on from there";
  for (int id = 0; id < keyframes.size(); ++id) EXPECT_TRUE(isPlausible(keyframes.pose(id))) << id;
}

TEST(FrontEnd, SurvivesScansThatReportNothing) {
  Drive drive;
  drive.run(2.0, kStand);
  auto empty = std::make_unique<LaserScan>();
  empty->stamp = drive.now;
  for (int i = 0; i < 50; ++i) {
    EXPECT_FALSE(drive.front_end->add(*empty).fused);
    empty->stamp += 100ms;
  }
  drive.run(6.0, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
}

TEST(FrontEnd, DoesNotAllocateAfterStartUp) {
  Drive drive;
  drive.run(1.0, kStand);
  EXPECT_EQ(test::allocationsDuring([&] { drive.run(5.0, kCurve); }), 0U);
}

TEST(FrontEnd, PlacesAnImageWhereTheRobotWasAtItsStampAndItsTimeOffset) {
  const auto laser = std::make_unique<PseudoLaser>();
  for (const double offset : {0.0, 0.2, -0.2}) {
    FrontEndConfig config;
    config.depth.time_offset = offset;
    Drive drive(config);
    KeyframeGraph keyframes;
    drive.keyframes = &keyframes;
    drive.run(2.0, kStand);
    drive.run(4.0, {0.5, 0, 0});
    laser->stamp = drive.now - 300ms;
    const DepthObservation* sight = drive.front_end->add(*laser);
    ASSERT_NE(sight, nullptr);
    const double driven = 0.5 * (3.7 + offset);  // [m]
    EXPECT_NEAR((keyframes.pose(sight->keyframe) * sight->T_keyframe_base).x, driven, 0.03) << offset;
  }
}

}  // namespace
}  // namespace slam::front_end_test
