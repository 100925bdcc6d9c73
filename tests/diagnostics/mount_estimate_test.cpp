// SPDX-License-Identifier: BSD-3-Clause
#include "diagnostics/mount_estimate.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <random>

#include "diagnostics/sensor_check.hpp"
#include "diagnostics/sensor_problems.hpp"

namespace slam {
namespace {

/// A robot that drives bends and turns on the spot, slow and fast, whose lidar is not where it is said to be; every
/// tenth match is wrong.
struct Turning {
  Eigen::Vector2d off{0.0, 0.0};                               // [m]
  double yaw = 0.0;                                            // [rad]
  double noise = 0.004;                                        // [m], [rad]
  double slip = 1.0, wheel_scale = 1.0;                        // [1]
  double centre = 0.0, centre_right = 0.0, centre_fast = 0.0;  // [m] that the wheels turn ahead of where they say
  double lag = 0.0;                                            // [s] of the scans, while the robot speeds up and brakes
  double left = 0.5;                                           // [1] of the turns
  bool gyro = true;
  int pairs = 120;

  void feed(auto&& take) const {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const auto noisy = [&](double value) { return value + noise * normal(random); };
    for (int i = 0; i < pairs; ++i) {
      const bool fast = uniform(random) < 0.5, straight = uniform(random) < 0.4;
      const double turn = (0.12 + 0.1 * uniform(random)) * (uniform(random) < left ? 1.0 : -1.0);
      const double seconds = fast ? 0.2 : 0.6;
      Pose2 wheels{straight ? 0.1 : 0.1 * uniform(random), 0.0, straight ? 0.0 : turn};
      const double ahead = centre + (turn < 0.0 ? centre_right : 0.0) + (fast ? centre_fast : 0.0);
      const Eigen::Rotation2Dd turned(wheels.theta);
      const auto lever = [&](const Eigen::Vector2d& from) -> Eigen::Vector2d { return turned * from - from; };
      const Eigen::Vector2d way = wheels.translation() + lever({-ahead, 0.0}) +
                                  Eigen::Vector2d(lag * wheels.x / seconds * (uniform(random) - 0.5), 0.0);
      const Eigen::Vector2d seen = Eigen::Rotation2Dd(-yaw) * way + lever(off);
      Pose2 scans{noisy(seen.x()), noisy(seen.y()), noisy(wheels.theta)};
      if (i % 10 == 9) scans = {uniform(random) - 0.5, uniform(random) - 0.5, wheels.theta};
      const Pose2 told{noisy(wheel_scale * wheels.x), noisy(0.0), noisy(slip * wheels.theta)};
      take(scans, told, noisy(wheels.theta), seconds);
    }
  }
  MountCorrection correction() const {
    MountEstimate estimate;
    feed([&](const auto&... evidence) { estimate.add(evidence...); });
    return estimate.correction();
  }
  SensorFindings findings() const {
    SensorCheck check;
    feed([&](const Pose2& scans, const Pose2& wheels, double gyro_turn, double seconds) {
      check.add({.scans = scans,
                 .wheels = wheels,
                 .gyro_turn = gyro ? std::optional(gyro_turn) : std::nullopt,
                 .seconds = seconds});
    });
    return check.findings();
  }
};

bool isEmpty(const MountCorrection& correction) { return !correction.offset && !correction.yaw; }

TEST(MountEstimate, FindsALidarThatIsElsewhere) {
  for (const Eigen::Vector2d& off : {Eigen::Vector2d(0.3, 0.0), Eigen::Vector2d(-0.2, 0.1), Eigen::Vector2d(0.0, 0.15),
                                     Eigen::Vector2d(-0.064, 0.0)}) {
    for (const double wheel_scale : {1.0, 0.9}) {
      const MountCorrection found = Turning{.off = off, .wheel_scale = wheel_scale}.correction();
      ASSERT_TRUE(found.offset) << off.transpose();
      EXPECT_LT((*found.offset - off).norm(), 0.015) << found.offset->transpose();
      EXPECT_FALSE(found.yaw) << *found.yaw;
    }
  }
}

TEST(MountEstimate, FindsALidarThatIsTurned) {
  for (const double yaw : {0.07, -0.07, 0.2}) {
    const MountCorrection found = Turning{.yaw = yaw, .noise = 0.003}.correction();
    ASSERT_TRUE(found.yaw) << yaw;
    EXPECT_NEAR(*found.yaw, yaw, 0.015);
    EXPECT_FALSE(found.offset) << found.offset->transpose();
  }
  const MountCorrection both = Turning{.off = {0.1, 0.0}, .yaw = 0.1}.correction();
  EXPECT_TRUE(both.yaw && both.offset);
}

TEST(MountEstimate, SaysNothingOfOneThatIsInItsPlace) {
  EXPECT_TRUE(isEmpty(Turning{}.correction()));
  EXPECT_TRUE(isEmpty(Turning{.off = {0.02, 0.0}}.correction()));
  EXPECT_TRUE(isEmpty(Turning{.yaw = 0.02}.correction()));
  EXPECT_TRUE(isEmpty(Turning{.noise = 0.02}.correction()));
  EXPECT_TRUE(isEmpty(Turning{.slip = 0.9, .wheel_scale = 1.1}.correction())) << "wheels that slip";
  EXPECT_TRUE(isEmpty(Turning{.slip = 1.15}.correction())) << "a wrong track";
  EXPECT_TRUE(isEmpty(Turning{.lag = 0.1}.correction())) << "scans that lag behind the wheels";
}

TEST(MountEstimate, SaysNothingWhereTurnsContradictEachOther) {
  EXPECT_TRUE(isEmpty(Turning{.centre = 0.12, .centre_right = -0.12}.correction())) << "left and right";
  EXPECT_TRUE(isEmpty(Turning{.centre_fast = 0.15}.correction())) << "slow and fast";
}

TEST(MountEstimate, WaitsForTurnsToBothSidesAndForAGyro) {
  EXPECT_TRUE(isEmpty(Turning{.off = {0.3, 0.0}, .pairs = 14}.correction()));
  EXPECT_TRUE(isEmpty(Turning{.off = {0.3, 0.0}, .left = 0.0}.correction()));
  const SensorFindings without = Turning{.off = {0.3, 0.0}, .gyro = false}.findings();
  for (const SensorFinding& finding : without.all()) EXPECT_NE(finding.fault, SensorFault::kLidarMountOff);
}

TEST(MountEstimate, WantsTurnsToBothSides) {
  MountEstimate estimate;
  const auto turn = [&](double angle) {
    for (int i = 0; i < 20; ++i) estimate.add({0, 0, angle}, {0, 0, angle}, angle, 0.5);
  };
  turn(0.2);
  EXPECT_TRUE(estimate.wantsTurns());
  turn(-0.2);
  EXPECT_FALSE(estimate.wantsTurns());
}

TEST(MountEstimate, IsAFindingThatNamesWhatToDo) {
  const SensorFindings findings = Turning{.off = {0.3, 0.0}}.findings();
  ASSERT_EQ(findings.size, 1U);
  EXPECT_EQ(findings.storage[0].fault, SensorFault::kLidarMountOff);
  const std::string words = problemOf(findings.storage[0]).words();
  EXPECT_NE(words.find("add 0.30 m to lidar.x"), std::string::npos) << words;
  EXPECT_NE(words.find("slam-calibrate"), std::string::npos) << words;
  const SensorFindings turned = Turning{.yaw = 0.07, .noise = 0.003}.findings();
  ASSERT_EQ(turned.size, 1U);
  EXPECT_EQ(turned.storage[0].fault, SensorFault::kLidarYawOff);
  EXPECT_NEAR(turned.storage[0].value, 0.07, 0.015);
}

}  // namespace
}  // namespace slam
