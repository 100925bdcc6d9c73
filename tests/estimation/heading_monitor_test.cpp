// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/heading_monitor.hpp"

#include <gtest/gtest.h>

#include "support/simulated/robot.hpp"

namespace slam::heading_monitor_test {
namespace {

constexpr double kDrift = 0.004;  // [rad/s]
const Eigen::Vector3d kStand(0, 0, 0), kStraight(0.5, 0, 0), kLeft(0.3, 0, 0.6), kRight(0.3, 0, -0.6);

/// Its matched scans tell its heading, with an error of 1.5 mrad and a drift.
class Drive : public test::SimulatedRobot {
 public:
  explicit Drive(unsigned seed = 1, const HeadingMonitorConfig& config = {})
      : SimulatedRobot(test::Room{}, {}, seed), monitor(config) {
    gyro.bias = 0.01;
    gyro.sigma = 0.003;
    matches.sigma.z() = 0.0015;
  }

  void go(double seconds, const Eigen::Vector3d& twist) {
    stands_ = twist.isZero();
    run(seconds, twist, *this);
  }
  void add(const WheelSample& sample) { gyro_monitor.add(sample, gyro.bias); }
  void add(const ImuSample& sample) { gyro_monitor.add(sample); }
  void add(const PoseMeasurement& match) {
    gyro_monitor.compare(match.stamp, match.T_map_base.theta, gyro.bias);
    monitor.compare(gyro_monitor, match.stamp - late, stands_, match.T_map_base.theta, 1e-6);
  }

  GyroMonitor gyro_monitor{EkfConfig{}};
  HeadingMonitor monitor;
  Duration late{0};  // the gyro's stamps, by the scans'

 private:
  bool stands_ = true;
};

TEST(HeadingMonitor, IsQuietWithSoundScansAndAGyroOfAnyScale) {
  for (const double scale : {1.0, 0.96, 1.03}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      Drive drive(seed);
      drive.gyro.reads = [&](double rate) { return 0.01 + scale * (rate - 0.01); };
      drive.go(2.0, kStand);
      for (int lap = 0; lap < 10; ++lap) {
        for (const auto& twist : {kStraight, kLeft, kStraight, kLeft, kRight}) drive.go(4.0, twist);
        EXPECT_FALSE(drive.monitor.contradicts()) << scale << ' ' << seed << ' ' << lap;
      }
    }
  }
}

TEST(HeadingMonitor, NoticesScansThatTurnWithinSecondsAndAcceptsThemLittle) {
  for (const double drift : {kDrift, -kDrift}) {
    Drive drive;
    drive.go(2.0, kStand);
    EXPECT_EQ(drive.monitor.matchError(), Eigen::Matrix3d::Zero());
    drive.matches.drift = drift;
    drive.go(5.0, kStraight);
    EXPECT_TRUE(drive.monitor.contradicts());
    EXPECT_NEAR(drive.monitor.drift(), drift, 0.5 * kDrift);
    EXPECT_EQ(drive.monitor.matchError(), Eigen::Matrix3d::Identity());
  }
}

TEST(HeadingMonitor, NeedsAGyroThatHasRested) {
  Drive drive;
  drive.matches.drift = kDrift;
  drive.go(20.0, kStraight);
  EXPECT_FALSE(drive.monitor.contradicts());
}

TEST(HeadingMonitor, TheNextRestShowsWhetherItWasTheGyro) {
  for (const bool gyro_is_wrong : {true, false}) {
    Drive drive;
    drive.go(2.0, kStand);
    (gyro_is_wrong ? drive.gyro.bias : drive.matches.drift) += 2.0 * kDrift;
    drive.go(6.0, kStraight);
    EXPECT_TRUE(drive.monitor.contradicts());
    drive.go(3.0, kStand);
    EXPECT_EQ(drive.monitor.contradicts(), !gyro_is_wrong);
    drive.go(30.0, kStraight);
    EXPECT_EQ(drive.monitor.contradicts(), !gyro_is_wrong);
  }
}

TEST(HeadingMonitor, AStopBetweenTwoScansIsNoRest) {
  Drive drive;
  drive.lidar.every = 50;
  drive.go(1.0, kLeft);
  drive.go(1.0, kStand);  // one scan of a robot that stands
  drive.matches.drift = kDrift;
  drive.go(20.0, kStraight);
  EXPECT_FALSE(drive.monitor.contradicts());
}

TEST(HeadingMonitor, StampsThatAreOffAreNoDrift) {
  for (const double time_offset : {HeadingMonitorConfig{}.time_offset, 0.0}) {
    int contradicted = 0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      HeadingMonitorConfig config;
      config.time_offset = time_offset;
      Drive drive(seed, config);
      drive.late = std::chrono::milliseconds(20);
      drive.go(1.2, kStand);
      drive.go(3.0, {0.4, 0.0, 0.35});
      drive.go(2.0, {0.2, 0.0, -0.65});
      contradicted += drive.monitor.contradicts();
    }
    EXPECT_EQ(contradicted > 0, time_offset == 0.0) << contradicted << " of 10";
  }
}

TEST(HeadingMonitor, ABiasMayMoveWhileNoScanIsMatched) {
  Drive drive;
  drive.go(2.0, kStand);
  drive.lidar.there = false;
  drive.go(600.0, kStraight);
  drive.gyro.bias += 0.003;
  drive.lidar.there = true;
  drive.go(20.0, kStraight);
  EXPECT_FALSE(drive.monitor.contradicts());
}

TEST(HeadingMonitor, AMapThatMovesIsNoDrift) {
  Drive drive;
  drive.go(2.0, kStand);
  for (int i = 0; i < 20; ++i) {
    drive.go(2.0, kStraight);
    drive.matches.pose.theta += 0.05;
    drive.monitor.interrupt();
  }
  EXPECT_FALSE(drive.monitor.contradicts());
}

TEST(HeadingMonitor, AsksNoGyroThatIsRejected) {
  Drive drive;
  drive.gyro.fault.degrees = true;
  drive.gyro.sigma = 0.0;
  drive.go(2.0, kStand);
  drive.go(20.0, kLeft);
  ASSERT_FALSE(drive.gyro_monitor.reliable());
  drive.matches.drift = kDrift;
  drive.go(20.0, kStraight);
  EXPECT_FALSE(drive.monitor.contradicts());
}

}  // namespace
}  // namespace slam::heading_monitor_test
