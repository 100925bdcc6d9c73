// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/body_watch.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "support/simulated/room.hpp"

namespace slam::test::body_watch_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr RangeLimits kLimits{0.05F, 12.0F};

/// A room of 8 m x 5 m, and a body at a range of 0.25 m over 40 degrees.
struct RobotWithBody {
  Room room{.length = 8.0, .width = 5.0};
  std::mt19937 random{1};
  bool has_body = true, upside_down = false;
  double body = 180 * kDegree;  // [rad] its middle, as seen from above

  double range(const Pose2& truth, double bearing) const {
    return has_body && isBehind(bearing - body + std::numbers::pi) ? 0.25 : room.range(truth, bearing);
  }
  std::vector<Beam> look(const Pose2& truth) {
    LaserScan scan = SimulatedLidar{}.scan(*this, truth, random);
    if (upside_down)
      for (Beam& beam : std::span(scan.storage).first(static_cast<std::size_t>(scan.size))) beam.bearing *= -1.0F;
    return {scan.beams().begin(), scan.beams().end()};
  }
  static bool isBehind(double bearing) { return std::abs(wrapAngle(bearing - std::numbers::pi)) < 20 * kDegree; }
};

LidarModel lidarAt(const Pose2& T_base_lidar, bool upside_down) {
  LidarModel lidar;
  lidar.T_base_lidar = T_base_lidar;
  lidar.upside_down = upside_down;
  return lidar;
}

int bodyBeams(const BodyWatch& watch, const std::vector<Beam>& beams) {
  int count = 0;
  for (const Beam& beam : beams) count += watch.isBody(beam);
  return count;
}

TEST(BodyWatch, FindsWhatKeepsItsRangeWhileTheRobotDrives) {
  RobotWithBody robot;
  BodyWatch watch{LidarModel{}};
  Pose2 pose{-2.0, 0.3, 0.2};
  for (int i = 0; i < 20; ++i, pose = pose * Pose2{0.12, 0.0, 0.02}) watch.add(robot.look(pose), kLimits, pose);
  const auto beams = robot.look(pose);
  int behind = 0;
  for (const Beam& beam : beams) {
    behind += RobotWithBody::isBehind(beam.bearing);
    EXPECT_TRUE(watch.isBody(beam) || !RobotWithBody::isBehind(beam.bearing)) << beam.bearing;
  }
  EXPECT_LE(bodyBeams(watch, beams), behind + 2);
  EXPECT_NEAR(watch.shape().degrees(), 40, 3);
  EXPECT_NEAR(std::abs(watch.shape().middle()), 180.0, 2.0);
}

TEST(BodyWatch, FindsTheSameBodyWithALidarUpsideDown) {
  for (const bool upside_down : {false, true}) {
    RobotWithBody robot{.upside_down = upside_down, .body = 150 * kDegree};
    BodyWatch watch{lidarAt({0.1, 0.05, 0.0}, upside_down)};
    Pose2 pose{-2.0, 0.3, 0.2};
    for (int i = 0; i < 20; ++i, pose = pose * Pose2{0.12, 0.0, 0.02})
      watch.add(robot.look(pose * Pose2{0.1, 0.05, 0.0}), kLimits, pose);
    EXPECT_NEAR(watch.shape().degrees(), 40, 3);
    EXPECT_NEAR(watch.shape().middle(), upside_down ? -150.0 : 150.0, 2.0) << "of the scan's own bearings";
  }
}

TEST(BodyWatch, OneStepIsEnoughWhereManyNeighboursStay) {
  RobotWithBody robot;
  BodyWatch watch{LidarModel{}};
  watch.add(robot.look({0.0, 0.0, 0.0}), kLimits, {0.0, 0.0, 0.0});
  watch.add(robot.look({0.12, 0.0, 0.0}), kLimits, {0.12, 0.0, 0.0});
  EXPECT_GE(bodyBeams(watch, robot.look({0.12, 0.0, 0.0})), 30);
  EXPECT_EQ(watch.shape().degrees(), 0) << "not sure yet";
  EXPECT_NEAR(watch.leftOut().degrees(), 38, 4) << "but left out";
  EXPECT_NEAR(std::abs(watch.leftOut().middle()), 180.0, 3.0);
}

TEST(BodyWatch, AWallBesideTheRobotIsNone) {  // whose range stays as long as the robot drives along it
  RobotWithBody robot;
  robot.has_body = false;
  robot.room = {.length = 60.0, .width = 2.0};
  BodyWatch watch{LidarModel{}};
  Pose2 pose{-25.0, 0.0, 0.0};
  for (int i = 0; i < 300; ++i, pose.x += 0.12) {
    const auto beams = robot.look(pose);
    watch.add(beams, kLimits, pose);
    ASSERT_LE(bodyBeams(watch, beams), 3) << i;
  }
  EXPECT_EQ(watch.shape().degrees(), 0);
}

TEST(BodyWatch, WheelsThatSpinMakeNoBodyOfTheRoom) {
  RobotWithBody robot;
  robot.has_body = false;
  BodyWatch watch{LidarModel{}};
  for (int i = 0; i < 50; ++i) watch.add(robot.look({1.0, 0.5, 0.3}), kLimits, {0.12 * i, 0.0, 0.0});
  EXPECT_EQ(bodyBeams(watch, robot.look({1.0, 0.5, 0.3})), 0);
}

TEST(BodyWatch, AMotionThatTheRoomContradictsMakesNone) {  // as of a lidar upside down, or of wheels that are swapped
  RobotWithBody robot;
  robot.has_body = false;
  robot.room = {.length = 3.0, .width = 2.0};
  BodyWatch watch{LidarModel{}};
  Pose2 truth{-0.5, 0.1, 0.0}, told = truth;
  for (int i = 0; i < 60; ++i) {
    const double turn = i % 20 < 10 ? 0.1 : -0.1;
    truth = truth * Pose2{i % 20 < 10 ? 0.06 : -0.06, 0.0, turn};
    told = told * Pose2{i % 20 < 10 ? 0.06 : -0.06, 0.0, -turn};
    const auto beams = robot.look(truth);
    watch.add(beams, kLimits, told);
    ASSERT_EQ(bodyBeams(watch, beams), 0) << i;
  }
}

TEST(BodyWatch, ForgetsABodyThatIsTakenOff) {
  RobotWithBody robot;
  BodyWatch watch{LidarModel{}};
  Pose2 pose{-2.0, 0.3, 0.0};
  for (int i = 0; i < 15; ++i, pose.x += 0.12) watch.add(robot.look(pose), kLimits, pose);
  ASSERT_GT(watch.shape().degrees(), 0);
  robot.has_body = false;
  for (int i = 0; i < 10; ++i, pose.x += 0.12) watch.add(robot.look(pose), kLimits, pose);
  EXPECT_EQ(watch.shape().degrees(), 0);
  robot.has_body = true;
  EXPECT_EQ(bodyBeams(watch, robot.look(pose)), 0);
}

TEST(BodyWatch, GoesOnWithTheShapeOfAnotherRun) {
  RobotWithBody robot;
  BodyWatch first{lidarAt({}, true)}, second{lidarAt({}, true)};
  Pose2 pose{-2.0, 0.3, 0.0};
  for (int i = 0; i < 15; ++i, pose.x += 0.12) first.add(robot.look(pose), kLimits, pose);
  second.begin(first.shape());
  EXPECT_GE(bodyBeams(second, robot.look(pose)), 36);
}

}  // namespace
}  // namespace slam::test::body_watch_test
