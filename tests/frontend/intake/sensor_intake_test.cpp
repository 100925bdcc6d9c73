// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/intake/sensor_intake.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "core/plausibility.hpp"
#include "frontend/drive.hpp"
#include "support/absurd.hpp"
#include "support/allocations.hpp"

namespace slam::sensor_intake_test {
namespace {

using namespace std::chrono_literals;
using test::Drive;
using test::kCurve;
using test::kSpin;
using test::kStand;

TEST(SensorIntake, UsesAScanOnceThatIsSentTwice) {
  Drive drive;
  drive.copied_after = 2ms;
  drive.run(2.0, kStand);
  drive.run(20.0, kCurve);
  EXPECT_LT(drive.error(), 0.03);
  const FrontEndCounters counters = drive.front_end->counters();
  EXPECT_GE(counters.scans_repeated, counters.scans / 2 - 2) << "but the first, whose usual interval is not known";
  EXPECT_LE(counters.matched, counters.scans / 2);
}

TEST(SensorIntake, DoesNotAcceptALidarThatRepeatsATurn) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(8.0, kCurve);
  drive.frozen = true;
  drive.run(4.0, kCurve);
  EXPECT_TRUE(drive.last.stuck);
  EXPECT_LT(drive.error(), 0.1) << "wheels and gyro go on";
  EXPECT_EQ(drive.state(), LocalisationState::kDegraded);
  drive.run(2.0, kStand);
  EXPECT_TRUE(drive.last.stuck) << "what it shows is as old as before";
  EXPECT_LT(drive.error(), 0.1);
  drive.frozen = false;
  drive.run(2.0, kStand);
  EXPECT_FALSE(drive.last.stuck);
  EXPECT_LT(drive.error(), 0.03);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
}

/// Walls along the way show the same again and again where ranges have coarse steps.
TEST(SensorIntake, UsesEachScanOfACoarseLidarBesideAWall) {
  for (const double step : {0.01, 0.05}) {
    for (const double reach : {12.0, 3.0}) {  // in sight of the ends, and out of it
      Drive drive(test::Room{.length = 40.0, .width = 2.0, .reach = reach}, {});
      drive.lidar.every = 4;
      drive.lidar.range_sigma = 0.002;
      drive.rearrange = [step](LaserScan& scan) {
        for (Beam& beam : std::span(scan.storage).first(static_cast<std::size_t>(scan.size)))
          beam.range = static_cast<float>(step * std::round(static_cast<double>(beam.range) / step));
      };
      drive.run(2.0, kStand);
      drive.run(30.0, {0.3, 0, 0});
      EXPECT_EQ(drive.front_end->counters().scans_repeated, 0U) << step << " m, " << reach << " m";
    }
  }
}

TEST(SensorIntake, IsNotBlindedByOneSampleFromTheFuture) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.front_end->add(WheelSample{drive.now + 8s, {}});
  drive.front_end->add(ImuSample{drive.now + 24h, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  auto scan = std::make_unique<LaserScan>();
  scan->stamp = drive.now + 8s;
  drive.front_end->add(*scan);
  drive.run(5.0, kCurve);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_LT(drive.error(), 0.03);
  EXPECT_EQ(drive.front_end->counters().far_ahead, 3U);
  EXPECT_EQ(drive.front_end->counters().scans_too_late, 0U);
}

TEST(SensorIntake, LeavesOutAndCountsNumbersThatCannotBe) {
  const auto driven = [](bool disturbed) {
    Drive drive;
    std::uint32_t absurd = 0;
    drive.run(1.0, kStand);
    for (const double value : test::absurdNumbers(kPlausible.dead_reckoned)) {
      drive.run(0.2, kCurve);
      if (!disturbed) continue;
      drive.front_end->add(WheelSample{drive.now, {value, 0.0, 0.0}});
      drive.front_end->add(WheelSample{drive.now, {0.0, 0.0, value}});
      drive.front_end->add(ImuSample{drive.now, {0.0, 0.0, value}});
      drive.front_end->add(ImuSample{drive.now, {0.0, 0.0, 0.0}, {value, 0.0, 0.0}});
      absurd += 4;
    }
    EXPECT_EQ(drive.front_end->counters().implausible, absurd);
    EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
    EXPECT_LT(drive.error(), 0.03);
    return drive.front_end->estimate(drive.now).T_map_base;
  };
  EXPECT_EQ(driven(true), driven(false)) << "to the last bit";
}

TEST(SensorIntake, CountsTimeThatWentBackAndGoesOn) {
  Drive drive;
  drive.run(3.0, kStand);
  drive.now -= 60s;          // the clock was set back
  drive.gyro.there = false;  // (an IMU sample that old is dropped and counted)
  drive.run(3.0, kStand);
  EXPECT_GT(drive.front_end->counters().clock_resets, 0U);
  EXPECT_TRUE(drive.last.fused);
}

TEST(SensorIntake, KeepsUsingTheGyroWhenAllClocksAreSetBack) {
  Drive drive;
  drive.run(4.0, {0.3, 0, 0.3});
  drive.now -= 1h;
  drive.run(4.0, {0.3, 0, 0.3});
  EXPECT_EQ(drive.front_end->counters().samples_too_old, 0U);
}

/// Samples of two filters that have run for a while.
struct Filters {
  Filters() {
    for (EkfTimeline* filter : {&odometry, &pose}) {
      for (int i = 0; i <= 200; ++i) filter->add(WheelSample{kBegin + i * 20ms, Pose2{speed * 0.02 * i, 0.0, 0.0}});
    }
  }
  static constexpr Timestamp kBegin{100s};
  double speed = 0.5;  // [m/s]
  EkfTimeline odometry{EkfConfig{}, EkfTimelineConfig{}};
  EkfTimeline pose{EkfConfig{}, EkfTimelineConfig{}};
};

TEST(SensorIntake, PutsEachStreamIntoTheFiltersTime) {
  IntakeConfig config;
  LidarModel lidar;
  config.wheel_time_offset = -0.02;
  config.imu_time_offset = 0.01;
  lidar.time_offset = 0.05;
  SensorIntake intake(config, lidar);
  const Filters filters;
  const Timestamp now = filters.odometry.newestStamp();
  EXPECT_EQ(intake.accept(WheelSample{now, {}})->stamp, now - 20ms);
  EXPECT_EQ(intake.accept(ImuSample{now}, now)->stamp, now + 10ms);
  LaserScan scan;
  scan.stamp = now;
  const SensorIntake::Scan accepted = intake.accept(scan, filters.pose, filters.odometry);
  EXPECT_TRUE(accepted.accepted);
  EXPECT_EQ(accepted.first, now + 50ms);
}

TEST(SensorIntake, LeavesOutAScanThatIsOlderThanTheFiltersWindow) {
  const Filters filters;
  const Timestamp oldest = filters.pose.oldestStamp();
  for (const auto& [late, accepted] : {std::pair(10ms, true), {-10ms, false}}) {
    SensorIntake intake({});
    LaserScan scan;
    scan.stamp = oldest + late;
    EXPECT_EQ(intake.accept(scan, filters.pose, filters.odometry).accepted, accepted) << late.count();
    FrontEndCounters counters;
    intake.addTo(counters);
    EXPECT_EQ(counters.scans, 1U);
    EXPECT_EQ(counters.scans_too_late, accepted ? 0U : 1U);
  }
}

}  // namespace
}  // namespace slam::sensor_intake_test
