// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/standstill.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "support/simulated/robot.hpp"

namespace slam::standstill_test {
namespace {

using std::chrono::milliseconds;

const StandstillConfig kConfig{
    .max_speed = 0.01, .max_turn_rate = 0.02, .max_gyro_swing = 0.05, .max_gyro_rate = 0.1, .min_time = 0.5};

/// A robot with wheels at 50 Hz and a gyro at 100 Hz.
struct Robot : test::SimulatedRobot {
  Standstill standstill;
  double known_bias = 0.0;  // [rad/s]

  /// @param gyro_noise [rad/s] at most
  explicit Robot(double gyro_noise = 0.0) : SimulatedRobot(test::Room{}) {
    gyro.per_step = 2;
    gyro.reads = [this, noise = std::uniform_real_distribution<double>(-gyro_noise, gyro_noise)](double rate) mutable {
      return rate + noise(random);
    };
  }

  bool run(double seconds, const Eigen::Vector3d& twist = {0, 0, 0}) {
    SimulatedRobot::run(seconds, twist, *this);
    return active();
  }
  void add(const WheelSample&) { standstill.addWheels(now, wheels.twist.x(), wheels.twist.z(), kConfig); }
  void add(const ImuSample& sample) {
    standstill.addGyro(sample.stamp, sample.gyro.z() - known_bias, kConfig.max_gyro_rate, kConfig);
  }
  bool active() const { return standstill.active(now, kConfig.min_time); }
};

TEST(Standstill, SeesARestingRobotThroughGyroNoiseAndBias) {
  Robot robot(0.02);
  robot.gyro.bias = robot.known_bias = 0.3;  // far above max_gyro_rate
  EXPECT_FALSE(robot.active());
  EXPECT_FALSE(robot.run(0.4));
  EXPECT_TRUE(robot.run(0.2));
  EXPECT_TRUE(robot.run(60.0));
}

TEST(Standstill, EndsAtOnceWhenTheWheelsMove) {
  for (const auto& [speed, turn_rate] : {std::pair{0.02, 0.0}, {-0.02, 0.0}, {0.0, 0.03}, {0.0, -0.03}}) {
    Robot robot;
    ASSERT_TRUE(robot.run(2.0));
    robot.wheels.spin = {speed, 0.0, turn_rate};
    EXPECT_FALSE(robot.run(0.02));
    robot.wheels.spin.setZero();
    EXPECT_FALSE(robot.run(0.4));  // the quiet time counts from anew
    EXPECT_TRUE(robot.run(0.2));
  }
}

TEST(Standstill, EndsAtOnceWhenTheRobotIsTurnedByHand) {
  for (const double rate : {0.2, -0.2}) {
    Robot robot;
    ASSERT_TRUE(robot.run(2.0));
    robot.wheels.turn_scale = 0.0;
    EXPECT_FALSE(robot.run(0.02, {0.0, 0.0, rate}));
    EXPECT_FALSE(robot.run(2.0, {0.0, 0.0, rate}));  // however evenly it is turned
    EXPECT_FALSE(robot.run(0.4));
    EXPECT_TRUE(robot.run(0.3));
  }
}

TEST(Standstill, AGyroThatSwingsMoreThanItsNoiseIsMotion) {
  Robot robot(0.04);  // swing of 0.08, each reading below max_gyro_rate
  EXPECT_FALSE(robot.run(5.0));
}

TEST(Standstill, NeedsNoGyro) {
  Robot robot;
  robot.gyro.there = false;
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
    (broken == 0 ? robot.wheels.spin.x() : broken == 1 ? robot.wheels.spin.z() : robot.gyro.bias) = kNan;
    EXPECT_FALSE(robot.run(2.0)) << broken;
  }
}

}  // namespace
}  // namespace slam::standstill_test
