// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/standstill.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace slam {
namespace {

using std::chrono::milliseconds;

const StandstillConfig kConfig{
    .max_speed = 0.01, .max_turn_rate = 0.02, .max_gyro_swing = 0.05, .max_gyro_rate = 0.1, .min_time = 0.5};

/// A robot with wheels at 50 Hz and a gyro at 100 Hz.
struct Robot {
  Standstill standstill;
  Timestamp now = Timestamp(milliseconds(5'000'000));
  double speed = 0.0, turn_rate = 0.0, gyro = 0.0, gyro_noise = 0.0, bias = 0.0;
  bool has_gyro = true;
  std::mt19937 random{1};

  bool run(double seconds) {
    std::uniform_real_distribution<double> noise(-gyro_noise, gyro_noise);
    for (const Timestamp end = now + fromSeconds(seconds); now < end;) {
      for (int i = 0; i < 2; ++i) {
        now += milliseconds(10);
        if (has_gyro) standstill.addGyro(now, gyro + noise(random) - bias, kConfig.max_gyro_rate, kConfig);
      }
      standstill.addWheels(now, speed, turn_rate, kConfig);
    }
    return active();
  }
  bool active() const { return standstill.active(now, kConfig.min_time); }
};

TEST(Standstill, SeesARestingRobotThroughGyroNoiseAndBias) {
  Robot robot;
  robot.gyro = robot.bias = 0.3;  // far above max_gyro_rate
  robot.gyro_noise = 0.02;
  EXPECT_FALSE(robot.active());
  EXPECT_FALSE(robot.run(0.4));
  EXPECT_TRUE(robot.run(0.2));
  EXPECT_TRUE(robot.run(60.0));
}

TEST(Standstill, EndsAtOnceWhenTheWheelsMove) {
  for (const auto& [speed, turn_rate] : {std::pair{0.02, 0.0}, {-0.02, 0.0}, {0.0, 0.03}, {0.0, -0.03}}) {
    Robot robot;
    ASSERT_TRUE(robot.run(2.0));
    robot.speed = speed;
    robot.turn_rate = turn_rate;
    EXPECT_FALSE(robot.run(0.02));
    robot.speed = robot.turn_rate = 0.0;
    EXPECT_FALSE(robot.run(0.4));  // the quiet time counts from anew
    EXPECT_TRUE(robot.run(0.2));
  }
}

TEST(Standstill, EndsAtOnceWhenTheRobotIsTurnedByHand) {
  for (const double rate : {0.2, -0.2}) {
    Robot robot;
    ASSERT_TRUE(robot.run(2.0));
    robot.gyro = rate;
    EXPECT_FALSE(robot.run(0.02));
    EXPECT_FALSE(robot.run(2.0));  // however evenly it is turned
    robot.gyro = 0.0;
    EXPECT_FALSE(robot.run(0.4));
    EXPECT_TRUE(robot.run(0.3));
  }
}

TEST(Standstill, AGyroThatSwingsMoreThanItsNoiseIsMotion) {
  Robot robot;
  robot.gyro_noise = 0.04;  // swing of 0.08, each reading below max_gyro_rate
  EXPECT_FALSE(robot.run(5.0));
}

TEST(Standstill, NeedsNoGyro) {
  Robot robot;
  robot.has_gyro = false;
  EXPECT_FALSE(robot.run(0.4));
  EXPECT_TRUE(robot.run(0.2));
}

TEST(Standstill, AQuietGyroAloneProvesNothing) {  // it is quiet on a straight drive, too
  Standstill standstill;
  Timestamp now;
  for (int i = 0; i < 500; ++i) standstill.addGyro(now += milliseconds(10), 0.0, 0.0, kConfig);
  EXPECT_FALSE(standstill.active(now, kConfig.min_time));
}

TEST(Standstill, ReadingsThatAreNoNumberAreNotQuiet) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (int broken = 0; broken < 3; ++broken) {
    Robot robot;
    (broken == 0 ? robot.speed : broken == 1 ? robot.turn_rate : robot.gyro) = kNan;
    EXPECT_FALSE(robot.run(2.0)) << broken;
  }
}

}  // namespace
}  // namespace slam
