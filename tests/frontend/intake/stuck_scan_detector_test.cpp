// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/intake/stuck_scan_detector.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <random>

#include "support/simulated/room.hpp"

namespace slam::stuck_scan_detector_test {
namespace {

using test::Room;

constexpr double kInterval = 0.1;  // [s] between two turns

/// A lidar that drives through a room or a corridor, and what wheels and gyro tell of it.
struct Driving {
  Room room{.length = 8.0, .width = 5.0};
  double step = 0.001;       // [m] of the ranges
  double sigma = 0.004;      // [m] of the ranges
  double returned = 1.0;     // [1] of the beams
  double told_turn = 0.0;    // [rad/s] that wheels and gyro tell besides
  bool upside_down = false;  // bearings grow clockwise
  bool frozen = false;
  Pose2 truth = {}, told = {};
  std::mt19937 random{1};
  LaserScan scan = {};
  StuckScanDetector watch{{}, upside_down ? -1.0 : 1.0};

  /// @return whether the lidar is stuck
  bool turn(const Eigen::Vector3d& twist) {
    truth = truth * exp(kInterval * twist);
    told = told * exp(kInterval * (twist + Eigen::Vector3d(0.0, 0.0, told_turn)));
    if (!frozen) measure();
    watch.add(scan);
    return watch.isStuck(twist.isZero() ? std::nullopt : std::optional(told));
  }

 private:
  void measure() {
    room.range_sigma = sigma;
    scan = room.scan(truth, random);
    std::bernoulli_distribution comes_back(returned);
    for (int i = 0; i < scan.size; ++i) {
      Beam& beam = scan.storage[static_cast<std::size_t>(i)];
      beam.range =
          comes_back(random) ? static_cast<float>(step * std::round(static_cast<double>(beam.range) / step)) : 0;
      if (upside_down) beam.bearing = -beam.bearing;
    }
  }
};

const Eigen::Vector3d kStand(0, 0, 0), kAhead(0.3, 0, 0), kSpin(0, 0, 0.5);

TEST(StuckScanDetector, TrustsALidarAtRestHoweverCoarseItsSteps) {
  for (const double step : {0.00025, 0.001, 0.01, 0.05}) {
    for (const double sigma : {0.004, 0.0}) {
      Driving robot{.step = step, .sigma = sigma};
      for (int i = 0; i < 50; ++i) ASSERT_FALSE(robot.turn(kStand)) << step;
      for (int i = 0; i < 50; ++i) ASSERT_FALSE(robot.turn(kSpin)) << step << ", and turns then";
    }
  }
}

/// Walls along the way, whose ranges do not change: all that the lidar sees, but where a wall ends.
TEST(StuckScanDetector, TrustsACoarseLidarBesideAWall) {
  for (const double length : {1000.0, 60.0}) {
    for (const double width : {1.5, 5.0}) {
      for (const double step : {0.01, 0.05, 0.1}) {
        for (const double sigma : {0.0, 0.005}) {
          for (const double returned : {1.0, 0.4}) {
            for (const double told_turn : {0.0, 0.003}) {
              Driving robot{.room = {.length = length, .width = width, .reach = 6.0, .beams = 720},
                            .step = step,
                            .sigma = sigma,
                            .returned = returned,
                            .told_turn = told_turn,
                            .truth = {-3.0, 0.2, 0.0}};
              for (int i = 0; i < 100; ++i)
                ASSERT_FALSE(robot.turn(2.0 * kAhead)) << length << " x " << width << ", " << step << ", " << sigma
                                                       << ", " << returned << ", " << told_turn << ", turn " << i;
            }
          }
        }
      }
    }
  }
}

TEST(StuckScanDetector, NoticesARepeatedTurnAndItsEnd) {
  for (const auto& [twist, soon] : {std::pair(kAhead, 6), {kSpin, 6}, {Eigen::Vector3d(0.05, 0, 0), 26}}) {
    for (const double step : {0.001, 0.01}) {
      for (const bool upside_down : {false, true}) {
        for (const double returned : {1.0, 0.4}) {
          Driving robot{.step = step, .returned = returned, .upside_down = upside_down};
          for (int i = 0; i < 5; ++i) ASSERT_FALSE(robot.turn(twist));
          robot.frozen = true;
          int turns = 1;
          while (!robot.turn(twist)) ASSERT_LT(++turns, soon) << twist.transpose();
          EXPECT_GE(turns, 2) << "one may be chance";
          EXPECT_TRUE(robot.turn(kStand)) << "what it shows is as old as before";
          robot.frozen = false;
          EXPECT_TRUE(robot.turn(twist)) << "the first half may be old";
          EXPECT_FALSE(robot.turn(twist));
        }
      }
    }
  }
}

TEST(StuckScanDetector, NoticesATurnThatIsRepeatedSinceTheRobotStood) {
  Driving robot{.step = 0.01};
  for (int i = 0; i < 20; ++i) ASSERT_FALSE(robot.turn(kStand));
  robot.frozen = true;
  for (int i = 0; i < 20; ++i) ASSERT_FALSE(robot.turn(kStand));
  int turns = 0;
  while (!robot.turn(kAhead)) ASSERT_LT(++turns, 6);
}

/// Nothing but the wall at its end tells a turn that is repeated from those of a corridor that goes on.
TEST(StuckScanDetector, NoticesARepeatedTurnByTheEndOfACorridor) {
  Driving robot{.room = {.length = 20.0, .width = 2.0, .reach = 6.0, .beams = 720}, .step = 0.05, .sigma = 0.0};
  robot.truth = {7.0, 0.0, 0.0};
  for (int i = 0; i < 3; ++i) ASSERT_FALSE(robot.turn(kAhead));
  robot.frozen = true;
  int turns = 0;
  while (!robot.turn(kAhead)) ASSERT_LT(++turns, 16);
}

TEST(StuckScanDetector, ReportsNothingOfScansWithoutReturns) {
  Driving robot{.returned = 0.0};
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(robot.turn(kAhead));
}

TEST(StuckScanDetector, TakesAnyBearing) {
  LaserScan scan = {};
  for (const float bearing : {-100.0F, -3.2F, 3.1415927F, 6.2831855F, 1e9F}) scan.push({2.0F, bearing, 0.0F, 0.0F});
  StuckScanDetector watch({.fewest = 1, .must_change = 1});
  for (int i = 0; i < 10; ++i) {
    watch.add(scan);
    EXPECT_EQ(watch.isRepeat(), i > 0);
    EXPECT_EQ(watch.isStuck(Pose2{0.5 * i, 0.0, 0.0}), i > 1);
  }
}

}  // namespace
}  // namespace slam::stuck_scan_detector_test
