// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/scan_monitor.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "core/pose_covariance.hpp"
#include "estimation/ekf_timeline.hpp"
#include "support/simulated/robot.hpp"

namespace slam::scan_monitor_test {
namespace {

constexpr double kSpeed = 0.5;  // [m/s]

EkfConfig smooth() {
  EkfConfig config;
  config.smooth = true;
  return config;
}

/// Its matched scans tell its way with an error of their own.
class Drive : public test::SimulatedRobot {
 public:
  explicit Drive(const ScanMonitorConfig& config = {}, const Pose2& start = {})
      : SimulatedRobot(test::Room{}, start), monitor(EkfConfig{}, config) {}

  /// @param share of the way that the scans tell  @param wheel_noise [m per sqrt(m)]
  void go(double metres, double share, double turn_rate = 0.0, double wheel_noise = 0.02) {
    matches.scale = share;
    wheels.scale = 1.0;
    wheels.sigma = wheel_noise * std::sqrt(kSpeed * toSeconds(kStep));
    run(metres / kSpeed, {kSpeed, 0.0, turn_rate}, *this);
  }
  /// The robot is pushed, which the wheels do not see.
  void push(double metres) {
    matches.scale = 1.0;
    wheels.scale = wheels.sigma = 0.0;
    run(metres / kSpeed, {kSpeed, 0.0, 0.0}, *this);
  }
  double sigma() const { return std::sqrt(monitor.covariance()(0, 0)); }  // [m] along the way

  void add(const WheelSample& sample) {
    odometry_.add(sample);
    wheel_monitor_.add(sample);
    gyro_monitor_.add(sample, gyro.bias);
  }
  void add(const ImuSample& sample) {
    odometry_.add(sample);
    gyro_monitor_.add(sample);
  }
  void add(const PoseMeasurement& match) {
    const Ekf odometry = odometry_.at(now);
    wheel_monitor_.compare(odometry, match.T_map_base, true);
    monitor.compare(odometry, match.T_map_base, covariance, wheel_monitor_, heading_monitor_);
    heading_monitor_.compare(gyro_monitor_, now, odometry.standstill(), match.T_map_base.theta, 1e-6);
  }

  ScanMonitor monitor;
  Eigen::Matrix3d covariance = 1e-6 * Eigen::Matrix3d::Identity();  // [m^2, rad^2] of each match, in map

 private:
  EkfTimeline odometry_{smooth(), {}};
  WheelMonitor wheel_monitor_{EkfConfig{}};
  GyroMonitor gyro_monitor_{EkfConfig{}};
  HeadingMonitor heading_monitor_;
};

TEST(ScanMonitor, IsQuietWhereScansAndWheelsMeasureOneWay) {
  for (const double turn_rate : {0.0, 0.3}) {
    Drive drive;
    drive.go(40.0, 1.0, turn_rate);
    EXPECT_FALSE(drive.monitor.contradicts());
    EXPECT_EQ(drive.monitor.covariance(), Eigen::Matrix3d::Zero());
  }
}

TEST(ScanMonitor, NoticesScansThatAreDraggedALittleAtEachStep) {
  Drive drive;
  drive.go(40.0, 1.0);  // the wheels' noise and scale are known
  drive.go(1.0, 0.85);
  EXPECT_FALSE(drive.monitor.contradicts()) << "15 cm of 1 m are noise, for all that is known";
  drive.go(6.0, 0.85);
  EXPECT_TRUE(drive.monitor.contradicts());
  EXPECT_GT(drive.sigma(), 0.3);
  EXPECT_LT(drive.sigma(), 1.05) << "no more than the scans are off";
}

TEST(ScanMonitor, NoticesAHeadingThatAMatchPutOffInATurnWhereTheGyrosScaleIsKnown) {
  for (const bool known : {true, false}) {
    Drive drive;
    drive.gyro.bias = 0.01;
    if (known) drive.run(3.0, {0, 0, 0}, drive);  // only a gyro that has rested is compared with the scans
    for (const double rate : {0.6, -0.6, 0.6, -0.6}) drive.go(2.0, 1.0, rate);
    EXPECT_EQ(drive.monitor.covariance()(2, 2), 0.0);
    drive.go(1.0, 1.0, 0.8);
    drive.matches.drift = 0.3;  // a scan of a corner that fits as well when it is turned
    drive.go(0.25, 1.0, 0.8);
    drive.matches.drift = 0.0;
    drive.go(0.1, 1.0, 0.8);
    EXPECT_EQ(std::sqrt(drive.monitor.covariance()(2, 2)) > 0.1, known);
  }
}

TEST(ScanMonitor, ForgetsOverItsMemory) {
  for (const auto& [memory, contradicts] : {std::pair(3.0, false), std::pair(100.0, true)}) {
    ScanMonitorConfig config;
    config.memory = memory;
    Drive drive(config);
    drive.go(40.0, 1.0);
    drive.go(3.0, 0.5);
    EXPECT_TRUE(drive.monitor.contradicts());
    drive.go(15.0, 1.0);
    EXPECT_EQ(drive.monitor.contradicts(), contradicts) << memory;
  }
}

TEST(ScanMonitor, SeesAPushAtOnceAndReportsHowFar) {
  Drive drive;
  drive.go(10.0, 1.0);
  drive.push(1.0);
  EXPECT_TRUE(drive.monitor.contradicts());
  EXPECT_GT(drive.sigma(), 0.8);
  EXPECT_LT(drive.sigma(), 1.0) << "what the noise explains is taken off";
  EXPECT_NEAR(drive.monitor.covarianceOf({0.0, 0.0, 0.0}).norm(), 0.0, 1e-12);
  EXPECT_NEAR(drive.monitor.covarianceOf({1.0, 0.0, 0.0})(0, 0), (1.0 - std::exp(-0.1)) * std::pow(drive.sigma(), 2),
              1e-9);
}

TEST(ScanMonitor, ForgetsWhereTheRobotIsSomewhereElseAndNotWhereTheMapMoved) {
  Drive drive;
  drive.go(10.0, 1.0);
  drive.push(1.0);
  drive.monitor.interrupt();
  EXPECT_TRUE(drive.monitor.contradicts());
  drive.monitor.reset();
  EXPECT_FALSE(drive.monitor.contradicts());
}

TEST(ScanMonitor, ForgetsVariancesTwiceAsFastAsErrors) {
  const auto noise = [](double memory, double way) {  // [m^2] by which a push of 1 m is made less
    ScanMonitorConfig config;
    config.memory = memory;
    Drive drive(config);
    drive.go(60.0, 1.0, 0.0, 0.0);
    drive.monitor.reset();
    drive.go(way, 1.0, 0.0, 0.0);
    drive.push(1.0);
    return 1.0 - std::pow(drive.sigma(), 2);
  };
  EXPECT_NEAR(noise(10.0, 60.0) / noise(1e9, 10.0), 0.5, 0.1) << "a long way counts as half the memory";
}

TEST(ScanMonitor, HasNothingToCompareWithoutWheels) {
  Drive drive;
  drive.wheels.there = false;
  drive.push(5.0);
  EXPECT_FALSE(drive.monitor.contradicts());
}

TEST(ScanMonitor, WheelsThatAreSilentContradictNobodyButTheDoubtRemains) {
  Drive drive;
  drive.go(10.0, 1.0);
  drive.push(1.0);
  const double before = drive.sigma();
  drive.wheels.there = false;
  drive.push(1.0);
  EXPECT_FALSE(drive.monitor.contradicts());
  EXPECT_EQ(drive.sigma(), before);
}

TEST(ScanMonitor, ContradictsFromSoManyStandardDeviationsOn) {
  for (const auto& [sigmas, contradicts] : {std::pair(3.0, true), std::pair(1e3, false)}) {
    ScanMonitorConfig config;
    config.contradiction = sigmas;
    Drive drive(config);
    drive.go(40.0, 1.0);
    drive.go(7.0, 0.8);
    EXPECT_EQ(drive.monitor.contradicts(), contradicts) << sigmas;
  }
}

TEST(ScanMonitor, AMatchThatIsUnsureAlongTheWayContradictsNoWheelsThere) {
  const double heading = 0.7;  // [rad] in map
  for (const bool along : {true, false}) {
    Drive drive({}, {0.0, 0.0, heading});
    drive.covariance = rotated(Eigen::Vector3d(along ? 4.0 : 1e-6, along ? 1e-6 : 4.0, 1e-6).asDiagonal(), heading);
    drive.go(40.0, 1.0);
    drive.go(7.0, 0.8);
    EXPECT_EQ(drive.monitor.contradicts(), !along);
  }
}

}  // namespace
}  // namespace slam::scan_monitor_test
