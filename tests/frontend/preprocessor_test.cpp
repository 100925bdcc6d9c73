// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/preprocessor.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "frontend/drive.hpp"
#include "support/allocations.hpp"

namespace slam::preprocessor_test {
namespace {

using namespace std::chrono_literals;
using test::Drive;
using test::kCurve;
using test::kSpin;
using test::kStand;

TEST(Preprocessor, DoesNotSwingAboutTheSpeedOfARobotWithoutWheelsWhoseLidarTakesItsTime) {
  for (const bool imu : {true, false}) {
    SCOPED_TRACE(imu ? "with gyro" : "scans alone");
    Drive drive;
    drive.wheels.there = false;
    drive.gyro.there = imu;
    drive.lidar.sweep = 0.18;
    drive.run(1.0, kStand);
    for (const double speed : {0.1, 0.4, 0.2}) {
      const Eigen::Vector3d twist(speed, 0, 0.1);
      drive.run(1.0, twist);
      double worst = 0.0, swing = 0.0;
      for (int i = 0; i < 40; ++i) {
        drive.run(0.1, twist);
        worst = std::max(worst, drive.error());
        swing = std::max(swing, drive.speedError(twist));
      }
      EXPECT_LT(worst, 0.04) << "[m]";
      EXPECT_LT(swing, 0.15) << "[m/s]";
    }
  }
}

TEST(Preprocessor, ASparseScanDoesNotHoldTheRobotInACorridor) {
  for (const int beams : {60, 90, 120}) {
    Drive drive;
    drive.enter(test::Room{.length = 80.0, .width = 2.0, .reach = 10.0});
    drive.lidar.beams = beams;
    drive.run(2.0, kStand);
    drive.run(20.0, {0.4, 0, 0});
    EXPECT_LT(drive.error(), 0.15) << beams << " beams; the wheels are right";
    EXPECT_EQ(drive.front_end->counters().wheels_rejected, 0U) << beams;
  }
}

TEST(Preprocessor, IsNotHeldInACorridorByWallsSeenTooFlat) {
  for (const double width : {1.6, 2.0, 3.0}) {
    for (const int beams : {180, 360, 720}) {
      for (const bool imu : {true, false}) {
        Drive drive;
        drive.gyro.there = imu;
        drive.enter(test::Room{.length = 80.0, .width = width, .reach = 12.0});
        drive.lidar.beams = beams;
        drive.run(2.0, kStand);
        drive.run(25.0, {0.4, 0, 0});
        EXPECT_LT(drive.error(), 0.2) << width << " m wide, " << beams << " beams; the wheels are right";
        EXPECT_EQ(drive.front_end->counters().wheels_rejected, 0U) << width << " m wide, " << beams << " beams";
      }
    }
  }
}

TEST(Preprocessor, UsesNoReturnsOutsideTheLimitsOfTheConfiguration) {
  FrontEndConfig config;
  config.lidar.range_max = 1.0;  // no wall is that near
  Drive drive(config);
  drive.run(3.0, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kInitialising);
}

TEST(Preprocessor, StampsBeforeAndBehindTheBeamsAreOne) {
  // The same turn, stamped at its first beam, at its last one, and with beams in the other order.
  std::array<Pose2, 3> poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Drive drive;
    drive.lidar.sweep = 0.18;
    drive.rearrange = [i](LaserScan& scan) {
      if (i == 1) {
        const float last = scan.beams().back().time_offset;
        scan.stamp += fromSeconds(last);
        for (int k = 0; k < scan.size; ++k) scan.storage[static_cast<std::size_t>(k)].time_offset -= last;
      }
      if (i == 2) std::reverse(scan.storage.begin(), scan.storage.begin() + scan.size);
    };
    drive.run(6.0, {0.3, 0, 0.6});
    EXPECT_LT(drive.error(), 0.03) << i;
    poses[i] = drive.front_end->estimate(drive.now).T_map_base;
  }
  for (const Pose2& pose : poses) EXPECT_LT(std::hypot(pose.x - poses[0].x, pose.y - poses[0].y), 0.005);
}

}  // namespace
}  // namespace slam::preprocessor_test
