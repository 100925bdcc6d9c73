// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/scan_monitor.hpp"

#include <chrono>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "estimation/ekf_timeline.hpp"

namespace slam {
namespace {

constexpr double kSpeed = 0.5;  // [m/s]

/// A robot with wheels and a gyro, whose scans are matched five times a second: they tell its way with an error of
/// their own.
class Drive {
 public:
  explicit Drive(const ScanMonitorConfig& config = {}) : monitor(EkfConfig{}, config) {}

  /// @param share of the way that the scans tell  @param wheel_noise [m per sqrt(m)]
  void go(double metres, double share, double turn_rate = 0.0, double wheel_noise = 0.02) {
    for (double way = 0.0; way < metres; way += 0.02 * kSpeed) {
      const Pose2 step{0.02 * kSpeed, 0.0, 0.02 * turn_rate};
      const double spread = wheel_noise * std::sqrt(step.x);
      T_wheels_ = T_wheels_ * Pose2{step.x + spread * normal_(random_), 0.0, step.theta};
      T_map_base_ = T_map_base_ * Pose2{share * step.x, 0.0, step.theta};
      add(turn_rate);
    }
  }
  /// The robot is pushed, which the wheels do not see.
  void push(double metres) {
    for (double way = 0.0; way < metres; way += 0.01) {
      T_map_base_ = T_map_base_ * Pose2{0.01, 0.0, 0.0};
      add(0.0);
    }
  }
  double sigma() const { return std::sqrt(monitor.covariance()(0, 0)); }  // [m] along the way

  ScanMonitor monitor;
  bool has_wheels = true;

 private:
  void add(double turn_rate) {
    now_ += std::chrono::milliseconds(20);
    const WheelSample wheels{now_, T_wheels_};
    if (has_wheels) odometry_.add(wheels);
    if (has_wheels) wheels_.hear(wheels);
    odometry_.add(ImuSample{now_, {0.0, 0.0, turn_rate}, {0.0, 0.0, 9.81}});
    if (++steps_ % 10 != 0) return;
    const Ekf odometry = odometry_.at(now_);
    wheels_.compare(odometry, T_map_base_, true);
    monitor.compare(odometry, T_map_base_, 1e-6 * Eigen::Matrix3d::Identity(), wheels_);
  }

  EkfTimeline odometry_{EkfConfig{}, {}};
  WheelMonitor wheels_{EkfConfig{}};
  Pose2 T_wheels_, T_map_base_;
  Timestamp now_{std::chrono::seconds(100)};
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_{0.0, 1.0};
  int steps_ = 0;
};

TEST(ScanMonitor, IsQuietWhereScansAndWheelsTellOneWay) {
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

TEST(ScanMonitor, SeesAPushAtOnceAndSaysHowFar) {
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

TEST(ScanMonitor, HasNothingToCompareWithoutWheels) {
  Drive drive;
  drive.has_wheels = false;
  drive.push(5.0);
  EXPECT_FALSE(drive.monitor.contradicts());
}

TEST(ScanMonitor, WheelsThatAreSilentContradictNobodyButTheDoubtRemains) {
  Drive drive;
  drive.go(10.0, 1.0);
  drive.push(1.0);
  const double before = drive.sigma();
  drive.has_wheels = false;
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

}  // namespace
}  // namespace slam
