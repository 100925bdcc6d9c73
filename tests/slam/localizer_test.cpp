// SPDX-License-Identifier: BSD-3-Clause
#include "slam/localizer.hpp"

#include <gtest/gtest.h>

#include "support/allocations.hpp"
#include "support/simulated_room.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

/// Drives a robot with wheels, gyro and a lidar in a room, in virtual time.
class Drive {
 public:
  explicit Drive(const LocalizerConfig& config = {}) : localizer(std::make_unique<Localizer>(config)) {}

  bool wheels = true, imu = true, lidar = true;
  double wheel_factor = 1.0;  // 0: the wheels do not see the motion
  test::Room room{.length = 8.0, .width = 5.0, .range_sigma = 0.01};
  std::unique_ptr<Localizer> localizer;
  Pose2 truth;
  Timestamp now{100s};

  void run(double seconds, const Eigen::Vector3d& twist) {
    const Timestamp end = now + fromSeconds(seconds);
    while (now < end) {
      now += 20ms;
      truth = truth * exp(0.02 * twist);
      dead_reckoned_ = dead_reckoned_ * exp(0.02 * wheel_factor * twist);
      if (wheels) localizer->add(WheelSample{now, dead_reckoned_});
      if (imu) localizer->add(ImuSample{now, {0, 0, twist.z() + 0.01 + 0.001 * noise_(random_)}, {0, 0, 9.81}});
      if (lidar && ++step_ % 9 == 0) {
        LaserScan scan = room.scan(truth, random_);
        scan.stamp = now;
        last = localizer->add(scan);
      }
    }
  }
  /// The wheels claim a motion that was none.
  void pretend(const Pose2& jump) { dead_reckoned_ = dead_reckoned_ * jump; }
  double error() const {
    const Pose2 difference = between(truth, localizer->estimate(now).T_map_base);
    return std::hypot(difference.x, difference.y);
  }
  LocalisationState state() const { return localizer->estimate(now).state; }
  ScanOutcome last;

 private:
  Pose2 dead_reckoned_;
  std::mt19937 random_{1};
  std::normal_distribution<double> noise_{0.0, 1.0};
  int step_ = 0;
};

const Eigen::Vector3d kStand(0, 0, 0), kCurve(0.3, 0, 0.4), kSpin(0, 0, 2.0);

TEST(Localizer, FollowsACurveUnderNoiseAndLearnsTheGyroBias) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(20.0, kCurve);
  EXPECT_LT(drive.error(), 0.03);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_NEAR(drive.localizer->odometry(drive.now).gyro_bias, 0.01, 0.002);
  EXPECT_GT(drive.localizer->counters().keyframes, 3U);
}

TEST(Localizer, FollowsAFastSpin) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(6.0, kSpin);
  EXPECT_LT(drive.error(), 0.03);
  EXPECT_LE(drive.localizer->counters().unmatched + drive.localizer->counters().gated,
            3U);  // the jolt at its begin and end
}

TEST(Localizer, WorksWithScansAlone) {
  Drive drive;
  drive.wheels = drive.imu = false;
  drive.run(1.0, kStand);
  drive.run(15.0, {0.2, 0, 0.2});
  EXPECT_LT(drive.error(), 0.05);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
}

TEST(Localizer, BelievesScansWhenTheWheelsSpinOnTheSpot) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.wheel_factor = 2.0;
  drive.run(5.0, {0.15, 0, 0});
  EXPECT_LT(drive.error(), 0.05);
}

TEST(Localizer, FindsItselfAfterTheWheelsPretendedAJump) {
  for (const Pose2 jump : {Pose2{0.5, 0.0, 0.0}, Pose2{-0.3, 0.4, 0.0}, Pose2{0.1, 0.1, 1.0}}) {
    Drive drive;
    drive.imu = false;
    drive.run(2.0, kStand);
    drive.run(4.0, kCurve);
    drive.pretend(jump);
    drive.run(1.0, kCurve);
    EXPECT_LT(drive.error(), 0.05);
    EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  }
}

TEST(Localizer, OutweighsWheelsThatKeepLying) {
  Drive drive;
  drive.imu = false;
  drive.run(2.0, kStand);
  drive.wheel_factor = -1.0;  // forwards is reported as backwards
  drive.run(10.0, kCurve);
  EXPECT_LT(drive.error(), 0.12);  // the wheels carry the pose astray for up to 180 ms after a scan
  EXPECT_TRUE(drive.last.fused);
}

TEST(Localizer, StopsKeepingScansOfAKnownPlaceButGoesOnLooking) {
  Drive drive;
  drive.run(2.0, kStand);
  for (int lap = 0; lap < 4; ++lap) drive.run(16.0, kCurve);  // circles of 0.75 m radius
  const auto known = drive.localizer->counters().keyframes;
  bool looked = false;
  for (int step = 0; step < 160; ++step) {
    drive.run(0.2, kCurve);
    looked |= drive.last.keyframe != nullptr && drive.last.keyframe->look;
  }
  EXPECT_EQ(drive.localizer->counters().keyframes, known);
  EXPECT_TRUE(looked);
}

TEST(Localizer, IsDegradedWithoutLidarAndLocalisedAgainWithIt) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(4.0, kCurve);
  drive.lidar = false;
  drive.run(3.0, kCurve);
  EXPECT_EQ(drive.state(), LocalisationState::kDegraded);
  EXPECT_LT(drive.error(), 0.15);
  drive.lidar = true;
  drive.run(2.0, kCurve);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_LT(drive.error(), 0.04);
}

TEST(Localizer, AFailedMatchNeverMovesThePose) {
  Drive drive;
  drive.run(3.0, kStand);
  const Pose2 before = drive.localizer->estimate(drive.now).T_map_base;
  drive.room = {.length = 3.0, .width = 2.4, .range_sigma = 0.01};  // the lidar sees something else altogether
  drive.run(1.0, kStand);
  EXPECT_FALSE(drive.last.fused);
  const Pose2 moved = between(before, drive.localizer->estimate(drive.now).T_map_base);
  EXPECT_LT(std::hypot(moved.x, moved.y), 0.005);
  EXPECT_EQ(drive.state(), LocalisationState::kDegraded);
}

TEST(Localizer, IsInitialisingUntilAScanIsPlaced) {
  Drive drive;
  drive.lidar = false;
  drive.run(2.0, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kInitialising);
}

TEST(Localizer, JoinsOdomAndMap) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(5.0, kCurve);
  const OdometryEstimate odometry = drive.localizer->odometry(drive.now);
  const Pose2 joined = odometry.T_map_odom * odometry.T_odom_base;
  const Pose2 error = between(drive.localizer->estimate(drive.now).T_map_base, joined);
  EXPECT_LT(std::hypot(error.x, error.y), 1e-9);
}

TEST(Localizer, SurvivesScansThatSayNothing) {
  Drive drive;
  drive.run(2.0, kStand);
  auto empty = std::make_unique<LaserScan>();
  empty->stamp = drive.now;
  for (int i = 0; i < 50; ++i) {
    EXPECT_FALSE(drive.localizer->add(*empty).fused);
    empty->stamp += 100ms;
  }
  drive.run(6.0, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
}

TEST(Localizer, IsNotBlindedByOneSampleFromTheFuture) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.localizer->add(WheelSample{drive.now + 8s, {}});
  drive.localizer->add(ImuSample{drive.now + 24h, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  auto scan = std::make_unique<LaserScan>();
  scan->stamp = drive.now + 8s;
  drive.localizer->add(*scan);
  drive.run(5.0, kCurve);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_LT(drive.error(), 0.03);
  EXPECT_EQ(drive.localizer->counters().far_ahead, 3U);
  EXPECT_EQ(drive.localizer->counters().scans_too_late, 0U);
}

TEST(Localizer, UsesNoReturnsOutsideTheLimitsOfTheConfiguration) {
  LocalizerConfig config;
  config.lidar.range_max = 1.0;  // no wall is that near
  Drive drive(config);
  drive.run(3.0, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kInitialising);
}

TEST(Localizer, CountsTimeThatWentBackAndGoesOn) {
  Drive drive;
  drive.run(3.0, kStand);
  drive.now -= 60s;   // the clock was set back
  drive.imu = false;  // (an IMU sample that old is dropped and counted)
  drive.run(3.0, kStand);
  EXPECT_GT(drive.localizer->counters().clock_resets, 0U);
  EXPECT_TRUE(drive.last.fused);
}

TEST(Localizer, DoesNotAllocateAfterStartUp) {
  Drive drive;
  drive.run(1.0, kStand);
  EXPECT_EQ(test::allocationsDuring([&] { drive.run(5.0, kCurve); }), 0U);
}

}  // namespace
}  // namespace slam
