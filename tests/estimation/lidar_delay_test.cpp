// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/lidar_delay.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "core/pose2.hpp"

namespace slam::lidar_delay_test {
namespace {

struct Log {
  double late = 0.0;     // [s] of the lidar's stamps behind the truth
  double bias = 0.02;    // [rad/s] of the gyro
  double scale = 1.0;    // [1] of what it reads
  double noise = 0.002;  // [rad] of a match, [rad/s] of the gyro
  double swing = 0.8;    // [rad] of the heading
  double seconds = 60.0;
  double wrong_share = 0.0;  // [1] of matches that are wrong by a radian
};

/// A robot that turns to and fro, gyro at 100 Hz, scans at 5.5 Hz.
LidarDelay listenedTo(const Log& log) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, log.noise);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto heading = [&](double t) { return log.swing * std::sin(0.9 * t) + 0.3 * log.swing * std::sin(2.3 * t); };
  LidarDelay offset;
  double scan = 0.0;
  for (double t = 0.0; t < log.seconds; t += 0.01) {
    const double rate = (heading(t + 1e-4) - heading(t - 1e-4)) / 2e-4;
    offset.addGyro(Timestamp(fromSeconds(t)), log.scale * rate + log.bias + normal(random));
    if (t < scan) continue;
    const double wrong = uniform(random) < log.wrong_share ? 1.0 : 0.0;
    offset.addScan(Timestamp(fromSeconds(scan + log.late)) + offset.used(),
                   wrapAngle(heading(scan) + 3.0 + wrong + normal(random)));
    scan += 1.0 / 5.5;
  }
  return offset;
}

class LidarDelayOf : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(LateBy, LidarDelayOf, testing::Values(-0.1, -0.012, 0.0, 0.0033, 0.05, 0.2));

TEST_P(LidarDelayOf, IsFoundWithinItsSigmas) {
  const auto estimate = listenedTo({.late = GetParam(), .wrong_share = 0.05}).estimate();
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->offset, -GetParam(), std::max(0.0005, 3.5 * estimate->sigma));
  EXPECT_LT(estimate->sigma, 0.004);
}

TEST(LidarDelay, IsNotGuessedFromARobotThatDoesNotTurn) { EXPECT_FALSE(listenedTo({.swing = 0.0}).estimate()); }

TEST(LidarDelay, IsNotGuessedBeyondItsRaster) { EXPECT_FALSE(listenedTo({.late = 0.4}).estimate()); }

TEST(LidarDelay, IsNotGuessedFromAFewScansOrWithoutGyro) {
  EXPECT_FALSE(listenedTo({.seconds = 3.0}).estimate());
  LidarDelay blind;
  for (int i = 0; i < 200; ++i) blind.addScan(Timestamp(fromSeconds(0.2 * i)), 0.1 * i);
  EXPECT_FALSE(blind.estimate());
}

TEST(LidarDelay, IsUsedOnceItIsFarLikelierThanNone) {
  EXPECT_NEAR(toSeconds(listenedTo({.late = 0.15, .seconds = 8.0}).used()), -0.15, 0.01);
  EXPECT_NEAR(toSeconds(listenedTo({.late = -0.2, .noise = 0.02}).used()), 0.2, 0.02);
  EXPECT_EQ(listenedTo({.late = 0.01}).used(), Duration(0)) << "so little does no harm";
}

TEST(LidarDelay, IsNotUsedOfAGyroThatShowsOtherTurns) {
  for (const double scale : {-1.0, 0.0, 57.3}) EXPECT_EQ(listenedTo({.scale = scale}).used(), Duration(0)) << scale;
}

TEST(LidarDelay, BringsTheGyrosBias) {
  const auto estimate = listenedTo({.late = 0.1, .bias = 0.05}).estimate();
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->gyro_bias.value, 0.05, 4.0 * std::sqrt(estimate->gyro_bias.variance));
  EXPECT_LT(estimate->gyro_bias.variance, 1e-4);
}

TEST(LidarDelay, TakesSamplesOutOfOrderAsNone) {
  LidarDelay offset = listenedTo({.late = 0.05});
  offset.addGyro(Timestamp(fromSeconds(1.0)), 1e9);
  offset.addScan(Timestamp(fromSeconds(1.0)), 1.0);
  ASSERT_TRUE(offset.estimate());
  EXPECT_NEAR(offset.estimate()->offset, -0.05, 0.002);
}

}  // namespace
}  // namespace slam::lidar_delay_test
