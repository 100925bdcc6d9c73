// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/dynamic_point_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <span>
#include <vector>

#include "matching/normals.hpp"
#include "support/allocations.hpp"
#include "support/simulated/robot.hpp"

namespace slam::dynamic_point_filter_test {
namespace {

constexpr double kLegRadius = 0.06;  // [m]
constexpr double kSquarely = 0.966;  // cosine of 15 degrees: a pane of glass sends beams back that meet it so

/// A robot that filters its scans, with legs that may go along. It matches nothing: its wheels are right.
class Walk {
 public:
  explicit Walk(const test::Room& room, const LidarMounting& lidar = Pose2{})
      : filter(lidar), robot_(room), lidar_(lidar) {
    robot_.lidar.range_sigma = 0.01;
    robot_.lidar.reach = room.reach;
  }

  void run(double seconds, const Eigen::Vector3d& twist) { robot_.run(seconds, twist, *this); }
  void add(const WheelSample& sample) { timeline.add(sample); }
  void add(LaserScan scan) {
    if (!pillars.empty()) legs.clear();
    for (const Eigen::Vector2d& pillar : pillars) legs.push_back(robot_.truth.inverse() * pillar);
    for (int i = 0; i < scan.size; ++i) {
      Beam& beam = scan.storage[static_cast<std::size_t>(i)];
      for (const Eigen::Vector2d& leg : legs) {
        const double along = leg.dot(Eigen::Vector2d(std::cos(beam.bearing), std::sin(beam.bearing)));
        const double past = std::sqrt(std::max(0.0, leg.squaredNorm() - along * along));
        if (along < 0.0 || past > kLegRadius) continue;
        beam.range = static_cast<float>(along - std::sqrt(kLegRadius * kLegRadius - past * past));
      }
      if (glass && std::abs(std::sin(robot_.truth.theta + beam.bearing)) < kSquarely) beam.range = 0.0F;
      open_[static_cast<std::size_t>(i)] = !blocked && beam.range == 0.0F;
      const double bearing = wrapAngle(beam.bearing - lidar_.T_base_lidar.theta);
      beam.bearing = static_cast<float>(lidar_.upside_down ? -bearing : bearing);
    }
    deskew(scan, {0.1F, 100.0F}, scan.stamp, lidar_, PoseHistory(2), points);
    estimateNormals(points, Eigen::Vector2d::Zero(), {});
    const int seen = onLegs(), all = static_cast<int>(points.size());
    const auto allocations = test::allocationCount();
    filter.apply(points, scan.stamp, timeline, scan.beams(),
                 std::span(open_).first(static_cast<std::size_t>(scan.size)), robot_.lidar.reach);
    EXPECT_EQ(test::allocationCount(), allocations);
    legs_seen = seen;
    legs_left = onLegs();
    walls_out = all - seen - (static_cast<int>(points.size()) - legs_left);
    worst_walls_out = std::max(worst_walls_out, walls_out);
  }
  /// The filter of the pose has nothing of the last seconds.
  void forget() { timeline = EkfTimeline({}, {}); }
  void carry(const Pose2& T_robot_carried) { robot_.truth = robot_.truth * T_robot_carried; }
  void reportATurnThatIsNone() { robot_.wheels.spin = {0.0, 0.0, 3.0}; }
  void reportAWayThatIsNone() { robot_.wheels.spin = {0.5, 0.0, 0.0}; }

  std::vector<Eigen::Vector2d> legs;     // [m] in base
  std::vector<Eigen::Vector2d> pillars;  // [m] in the world, as thick
  bool glass = false;                    // the walls beside are
  bool blocked = false;                  // beams without return show nothing
  ScanPoints points;
  EkfTimeline timeline{{}, {}};
  DynamicPointFilter filter;
  int legs_seen = 0, legs_left = 0, walls_out = 0, worst_walls_out = 0;  // points of the newest scan

 private:
  int onLegs() const {
    return static_cast<int>(std::ranges::count_if(points, [this](const ScanPoint& point) {
      return std::ranges::any_of(legs, [&](const auto& leg) { return (point.position - leg).norm() < 0.1; });
    }));
  }
  test::SimulatedRobot robot_;
  const LidarMounting lidar_;  // which only turns the bearings
  std::array<bool, LaserScan::kCapacity> open_{};
};

const std::vector<Eigen::Vector2d> kBehind{{-0.55, 0.1}, {-0.55, -0.1}}, kBeside{{0.1, 0.9}, {-0.1, 0.9}};
const Eigen::Vector3d kAhead(0.4, 0.0, 0.0), kCurve(0.3, 0.0, 0.4), kWideCurve(0.4, 0.0, 0.1), kStand(0.0, 0.0, 0.0);

TEST(DynamicPointFilter, LeavesOutWhoGoesAlongInARoomAndKeepsItsWalls) {
  for (const auto& legs : {kBehind, kBeside}) {
    for (const Eigen::Vector3d& twist : {kAhead, kWideCurve}) {
      Walk walk({.length = 12.0, .width = 8.0});
      walk.legs = legs;
      walk.run(6.0, twist);
      EXPECT_GT(walk.legs_seen, 8);
      EXPECT_LE(walk.legs_left, 2) << "of " << walk.legs_seen;
      EXPECT_LE(walk.worst_walls_out, 4) << "in the shadow of legs that are gone a wall is new";
    }
  }
}

TEST(DynamicPointFilter, KeepsAllWhereNothingMoves) {
  Walk walk({.length = 9.0, .width = 6.0});
  walk.run(3.0, kAhead);
  walk.run(8.0, {0.0, 0.0, 0.8});
  walk.run(8.0, kCurve);
  EXPECT_EQ(walk.worst_walls_out, 0);
}

TEST(DynamicPointFilter, KeepsThinThingsThatStandStill) {
  Walk walk({.length = 12.0, .width = 8.0});
  walk.pillars = {{1.5, 0.8}, {1.5, -0.8}, {3.0, 1.5}};
  for (int i = 0; i < 60; ++i) {
    walk.run(0.2, i < 30 ? kAhead : kCurve);
    EXPECT_GE(walk.legs_left, walk.legs_seen - 2) << "at its rim a beam passes by";
  }
  EXPECT_LE(walk.worst_walls_out, 4);
}

TEST(DynamicPointFilter, TakesBeamsThatSawNothingForFreeSpaceUnlessTheyAreBlocked) {
  const test::Room hall{.length = 60.0, .width = 8.0, .reach = 12.0};  // nothing comes back from ahead
  const std::vector<Eigen::Vector2d> ahead{{1.5, 0.1}, {1.5, -0.1}};
  for (const auto& lidar : {LidarMounting(Pose2{}), LidarMounting({0.0, 0.0, 0.7}, true)}) {
    Walk open(hall, lidar), blocked(hall, lidar);
    blocked.blocked = true;
    for (Walk* walk : {&open, &blocked}) {
      walk->run(4.0, kAhead);
      walk->legs = ahead;  // somebody steps before the robot
      walk->run(0.2, kAhead);
    }
    EXPECT_GT(open.legs_seen, 4);
    EXPECT_EQ(open.legs_left, 0);
    EXPECT_EQ(blocked.legs_left, blocked.legs_seen);
  }
}

TEST(DynamicPointFilter, BeginsAnewWhereTheFilterDoesNotReachBack) {
  Walk walk({.length = 12.0, .width = 8.0});
  walk.legs = kBehind;
  walk.run(4.0, kAhead);
  ASSERT_LE(walk.legs_left, 2);
  walk.forget();
  walk.run(0.2, kAhead);
  EXPECT_EQ(walk.legs_left, walk.legs_seen);
  walk.run(3.0, kAhead);
  EXPECT_LE(walk.legs_left, 2);
}

TEST(DynamicPointFilter, FindsWallsInTheOpenOnceTheRobotWasCarried) {
  Walk walk({.length = 12.0, .width = 8.0});
  walk.legs = kBeside;
  walk.run(5.0, kAhead);
  EXPECT_GT(walk.filter.walls().consistent, 100);
  EXPECT_LT(walk.filter.walls().freeSpaceViolation(), 0.1) << "who goes along has no walls";
  walk.carry({-2.5, 1.5, 0.5});
  walk.run(0.4, kStand);
  EXPECT_GT(walk.filter.walls().freeSpaceViolation(), 0.4);
  walk.filter.forget();
  walk.run(0.2, kStand);
  EXPECT_EQ(walk.filter.walls().visible(), 0);
}

TEST(DynamicPointFilter, GlassThatEarlierScansMetAtAnotherAngleIsNoWallInTheOpen) {
  const test::Room hall{.length = 60.0, .width = 5.0, .reach = 12.0};
  for (const double side : {-1.0, 0.0, 1.0}) {
    Walk walk(hall);
    walk.glass = true;
    walk.carry({0.0, side, 0.0});
    walk.run(4.0, kAhead);
    VisibilityTally walls;
    for (int i = 0; i < 20; ++i) {
      walk.run(0.2, kAhead);
      walls.consistent += walk.filter.walls().consistent;
      walls.violated += walk.filter.walls().violated;
    }
    EXPECT_GT(walls.visible(), 100);
    EXPECT_LT(walls.freeSpaceViolation(), 0.2) << side;
  }
}

TEST(DynamicPointFilter, LeavesAllInWhereItIsTheMotionThatIsWrong) {
  Walk walk({.length = 5.0, .width = 4.0});
  walk.reportAWayThatIsNone();
  walk.run(8.0, kStand);
  EXPECT_LT(walk.walls_out, 120) << "of 360: those behind, which an earlier scan seems to see through";
  EXPECT_GT(walk.points.size(), 200U);

  Walk turned({.length = 12.0, .width = 8.0});
  turned.run(4.0, kAhead);
  turned.reportATurnThatIsNone();
  turned.run(0.2, kAhead);
  EXPECT_EQ(turned.walls_out, 0) << "of a room that seems to be turned";
}

}  // namespace
}  // namespace slam::dynamic_point_filter_test
