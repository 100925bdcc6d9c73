// SPDX-License-Identifier: BSD-3-Clause
#include "diagnostics/mount_estimate.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <random>

#include "diagnostics/sensor_check.hpp"

namespace slam {
namespace {

/// Turns of a robot whose lidar is not where it is said to be; every tenth match is wrong.
struct Turning {
  Eigen::Vector2d off{0.0, 0.0};  // [m]
  double noise = 0.006, slip = 1.0, yaw = 0.0, wheel_scale = 1.0;
  bool both_ways = true;
  int turns = 60;

  void feed(auto&& take) const {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto noisy = [&](double value) { return value + noise * normal(random); };
    for (int i = 0; i < turns; ++i) {
      const double turn = (0.12 + 0.1 * std::abs(uniform(random))) * (both_ways && i % 2 == 0 ? -1.0 : 1.0);
      const Pose2 truth{0.1 + 0.1 * uniform(random), 0.0, turn};
      const Eigen::Vector2d seen = Eigen::Rotation2Dd(yaw) * truth.translation() +
                                   (Eigen::Rotation2Dd(turn).toRotationMatrix() - Eigen::Matrix2d::Identity()) * off;
      Pose2 scans{noisy(seen.x()), noisy(seen.y()), noisy(turn)};
      if (i % 10 == 9) scans = {uniform(random), uniform(random), turn};
      take(scans, Pose2{noisy(wheel_scale * truth.x), noisy(0.0), noisy(slip * turn)});
    }
  }
  std::optional<Eigen::Vector2d> offset() const {
    MountEstimate estimate;
    feed([&](const Pose2& scans, const Pose2& wheels) { estimate.add(scans, wheels); });
    return estimate.offset();
  }
};

TEST(MountEstimate, FindsALidarThatIsElsewhere) {
  for (const Eigen::Vector2d& off :
       {Eigen::Vector2d(0.3, 0.0), Eigen::Vector2d(-0.2, 0.1), Eigen::Vector2d(0.0, 0.15)}) {
    const auto found = Turning{.off = off}.offset();
    ASSERT_TRUE(found) << off.transpose();
    EXPECT_LT((*found - off).norm(), 0.04) << found->transpose();
  }
}

TEST(MountEstimate, SaysNothingOfOneThatIsInItsPlace) {
  EXPECT_FALSE(Turning{}.offset());
  EXPECT_FALSE((Turning{.off = {0.03, 0.0}}.offset()));
  EXPECT_FALSE((Turning{.noise = 0.02}.offset()));
  EXPECT_FALSE((Turning{.slip = 0.9, .wheel_scale = 1.1}.offset())) << "wheels that slip";
  EXPECT_FALSE((Turning{.yaw = 0.1}.offset())) << "a lidar that is turned";
}

TEST(MountEstimate, WaitsForTurnsToBothSides) {
  EXPECT_FALSE((Turning{.off = {0.3, 0.0}, .turns = 14}.offset()));
  EXPECT_FALSE((Turning{.off = {0.3, 0.0}, .both_ways = false}.offset()));
}

TEST(MountEstimate, IsAFindingThatNamesWhatToDo) {
  SensorCheck check;
  Turning{.off = {0.3, 0.0}}.feed(
      [&](const Pose2& scans, const Pose2& wheels) { check.add({.scans = scans, .wheels = wheels}); });
  const SensorFindings findings = check.findings();
  ASSERT_EQ(findings.size, 1U);
  EXPECT_EQ(findings.storage[0].fault, SensorFault::kLidarMountOff);
  const std::string words = describe(findings.storage[0]);
  EXPECT_NE(words.find("add 0.3"), std::string::npos) << words;
  EXPECT_NE(words.find("slam-calibrate"), std::string::npos) << words;
}

}  // namespace
}  // namespace slam
