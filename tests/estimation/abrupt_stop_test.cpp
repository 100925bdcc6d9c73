// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/abrupt_stop.hpp"

#include <gtest/gtest.h>
#include <numbers>

namespace slam::abrupt_stop_test {
namespace {

constexpr double kBraking = 9.81, kStep = 0.02, kSpeed = 0.5;  // [m/s^2, s, m/s]

Timestamp at(double seconds) { return Timestamp(fromSeconds(seconds)); }

/// Wheels that stop at 0 s, at the map's origin. @param heading [rad] of the robot
AbruptStop stopped(double heading = 0.0) {
  AbruptStop stop;
  for (int i = 0; i < 5; ++i) stop.move({kSpeed, 0.0});
  EXPECT_FALSE(stop.stand(kBraking, kStep, at(0.0), {0.0, 0.0, heading}));
  EXPECT_TRUE(stop.stand(kBraking, kStep, at(0.0), {0.0, 0.0, heading}));
  return stop;
}

TEST(AbruptStop, IsOneThatTyresCannotMake) {
  AbruptStop braking;
  for (double speed = kSpeed; speed > 0.0; speed -= 0.15) braking.move({speed, 0.0});
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(braking.stand(kBraking, kStep, at(0.0), {}));
  EXPECT_FALSE(braking.doubtful());
  EXPECT_TRUE(stopped().doubtful());
  EXPECT_EQ(stopped().speed(), kSpeed);
}

TEST(AbruptStop, IsNoneOfCoarseCounters) {
  AbruptStop stop;
  for (int i = 0; i < 100; ++i) {
    if (i % 4 == 0) {
      stop.move({2.0, 0.0});
    } else {
      EXPECT_FALSE(stop.stand(kBraking, kStep, at(0.0), {}));
    }
  }
  for (int i = 0; i < 100; ++i) {  // one interval of three is empty
    if (i % 3 != 0) {
      stop.move({2.0, 0.0});
    } else {
      EXPECT_FALSE(stop.stand(kBraking, kStep, at(0.0), {}));
    }
  }
}

TEST(AbruptStop, OfARobotThatDrivesOnIsOfDeadWheels) {
  for (const double turn : {0.0, 0.8, -1.5}) {
    AbruptStop stop = stopped(0.7);
    const double seconds = 2.0;
    const Pose2 driven = Pose2{0.0, 0.0, 0.7} * exp(Eigen::Vector3d(kSpeed * seconds, 0.0, turn));
    stop.decide(at(seconds), driven, 0.04);
    EXPECT_TRUE(stop.dead()) << turn;
    EXPECT_TRUE(stop.doubtful());
    stop.move({kSpeed, 0.0});
    EXPECT_FALSE(stop.dead() || stop.doubtful()) << "they move again";
  }
}

TEST(AbruptStop, OfARobotThatStandsOrIsCarriedIsTrue) {
  for (const Pose2& seen : {Pose2{0.02, 0.0, 0.0}, Pose2{-1.0, 0.0, 0.0}, Pose2{0.5, -1.0, 2.0}}) {
    AbruptStop stop = stopped();
    stop.decide(at(2.0), seen, 0.04);
    EXPECT_FALSE(stop.dead() || stop.doubtful());
  }
}

TEST(AbruptStop, IsNotDecidedBeforeItCanBeSeen) {
  AbruptStop stop = stopped();
  stop.decide(at(0.1), {}, 0.04);
  EXPECT_TRUE(stop.doubtful() && !stop.dead());
  stop.decide(at(2.0), {}, 1.2);
  EXPECT_TRUE(stop.doubtful() && !stop.dead()) << "along a bare corridor";
}

TEST(AbruptStop, MovesWithTheMap) {
  const Pose2 T_new_old{3.0, -1.0, 2.0};
  AbruptStop stop = stopped();
  stop.transform(T_new_old);
  stop.decide(at(2.0), T_new_old * Pose2{1.0, 0.0, 0.0}, 0.04);
  EXPECT_TRUE(stop.dead());
  AbruptStop placed = stopped();
  placed.beginAt(at(2.0), {5.0, 5.0, 0.0});
  placed.decide(at(4.0), {6.0, 5.0, 0.0}, 0.04);
  EXPECT_TRUE(placed.dead());
}

}  // namespace
}  // namespace slam::abrupt_stop_test
