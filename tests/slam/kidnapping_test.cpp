// SPDX-License-Identifier: BSD-3-Clause
// A robot that is carried away, begins in a stored map, or is told where it is: the whole pipeline.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <utility>
#include <vector>

#include "slam/robot.hpp"
#include "support/stored_map.hpp"

namespace slam::kidnapping_test {
namespace {

using test::Robot;

constexpr double kPi = std::numbers::pi;
constexpr double kTold = 0.3;  // [m] a pose that is further off is wrong
const Pose2 kStart{1.2, 2.5, 0.0}, kInA{2.8, 1.6, 0.0}, kInB{10.2, 2.0, 0.0};
const Eigen::Vector3d kCircle(0.3, 0.0, 0.5);  // [m/s, m/s, rad/s] free of walls from kInA and kInB

/// A room and a crooked hall with a door between them. In two rooms of one shape half of a scan agrees, and no match is
/// missed.
test::Place flat() {
  test::Place place{.name = "Flat", .low = {0.3, 0.3}, .high = {13.7, 4.7}, .reach = 10.0};
  test::addWalls(place.world, {{0, 0}, {6, 0}, {16, -3}, {14, 4}, {10, 8}, {6, 5}, {0, 5}});
  place.world.addWall({6.0, 0.0}, {6.0, 1.9});
  place.world.addWall({6.0, 3.1}, {6.0, 5.0});
  place.world.add(sim::Box{1.0, 4.3, 0.0, 1.5, 0.9});
  place.world.add(sim::Box{4.6, 0.7, 0.4, 1.0, 0.7});
  place.world.add(sim::Cylinder{9.0, 1.4, 0.3});
  place.world.add(sim::Box{12.3, 1.5, 0.7, 0.9, 0.6});
  place.world.add(sim::Box{7.2, 0.6, 0.0, 1.2, 0.6});
  return place;
}

/// From the start through both rooms and back.
void tour(Robot& robot) {
  robot.run(1.0, {0, 0, 0});
  for (const double side : {9.1, 1.2, 1.1}) robot.drive(side), robot.turn(kPi / 2);
  robot.drive(1.2);
  robot.turn(-kPi / 2);
  robot.drive(8.0);
  robot.turn(kPi);
  robot.drive(1.0);
}

/// A map of both rooms, made once.
const MapState& given() {
  static const MapState map = [] {
    Robot robot(flat(), kStart);
    tour(robot);
    EXPECT_EQ(robot.state(), LocalisationState::kLocalised);
    EXPECT_LT(robot.error(kStart), 0.05);
    return robot.pipeline.state();
  }();
  return map;
}

/// A robot that goes on in that map.
class Kidnapping : public testing::TestWithParam<bool> {
 protected:
  Kidnapping() : robot(flat(), kInA, GetParam(), given()) {
    robot.after_scan = [this] {
      const bool wrong = robot.error(kStart) > kTold;
      wrong_poses += wrong && robot.state() == LocalisationState::kLocalised;
      was_lost |= robot.state() == LocalisationState::kLost;
      if (!robot.pipeline.frontEnd().placed())
        drawn_while_lost = std::max(drawn_while_lost, robot.pipeline.mapper().keyframes());
    };
  }
  /// @return whether it was found within a distance
  bool driveUntilFound(double metres) {
    for (double driven = 0.0; driven < metres; driven += 0.06) {
      robot.run(0.2, kCircle);
      if (robot.pipeline.frontEnd().placed() && robot.state() == LocalisationState::kLocalised) return true;
    }
    return false;
  }
  Robot robot;
  int wrong_poses = 0;  // that were called good
  bool was_lost = false;
  int drawn_while_lost = 0;
};

TEST_P(Kidnapping, IsNoticedAndTheRobotFoundAgain) {
  EXPECT_EQ(robot.state(), LocalisationState::kInitialising);
  ASSERT_TRUE(driveUntilFound(6.0));
  robot.run(12.0, kCircle);
  EXPECT_LT(robot.error(kStart), 0.05);
  const int keyframes = robot.pipeline.mapper().keyframes();

  robot.truth = kInB;
  int scans = 0;
  for (; robot.pipeline.frontEnd().counters().lost == 0 && scans < 100; ++scans) robot.run(0.2, {0, 0, 0});
  EXPECT_LE(scans, robot.pipeline.frontEnd().config().tracking.max_failures + 2);
  EXPECT_EQ(robot.pipeline.frontEnd().counters().lost, 1U);
  const int first = robot.pipeline.backEnd().keyframes().size();
  for (int i = 0; i < 4 && !robot.pipeline.frontEnd().placed(); ++i) {
    robot.run(0.2, kCircle);
    for (int id = first; id < robot.pipeline.backEnd().keyframes().size(); ++id) {
      EXPECT_EQ(robot.pipeline.backEnd().map().inMap(id), robot.pipeline.frontEnd().placed() && !GetParam()) << id;
    }
  }
  ASSERT_TRUE(driveUntilFound(8.0));
  EXPECT_LT(robot.error(kStart), 0.05);
  robot.run(12.0, kCircle);
  EXPECT_LT(robot.error(kStart), 0.05);
  EXPECT_EQ(robot.state(), LocalisationState::kLocalised);
  EXPECT_EQ(robot.pipeline.frontEnd().counters().lost, 1U);
  EXPECT_EQ(robot.pipeline.backEnd().counters().placed, 2);
  EXPECT_EQ(wrong_poses, 0);
  EXPECT_EQ(drawn_while_lost, keyframes) << "what an unfound robot sees is not drawn";
  if (GetParam()) return;
  EXPECT_GT(robot.pipeline.mapper().keyframes(), keyframes) << "found, it is drawn";
  for (int id = 0; id < robot.pipeline.backEnd().keyframes().size(); ++id)
    EXPECT_TRUE(robot.pipeline.backEnd().map().inMap(id)) << id;
}

TEST_P(Kidnapping, SoonAfterItWasFoundItLeavesTheMapAsItWas) {
  ASSERT_TRUE(driveUntilFound(6.0));
  const KeyframeMap& map = robot.pipeline.backEnd().map();
  const std::vector<int> given = map.idsInMap();
  robot.run(1.3, kCircle);
  EXPECT_EQ(map.idsInMap(), given);
  robot.truth = kInB;
  ASSERT_TRUE(driveUntilFound(8.0));
  EXPECT_EQ(robot.pipeline.frontEnd().counters().lost, 1U);
  EXPECT_EQ(map.idsInMap(), given);
  EXPECT_EQ(robot.pipeline.backEnd().counters().taken_back, GetParam() ? 0 : 1);
}

/// A hall that would look the same from its other end, were it not for what stands in one corner.
test::Place nearlySymmetricHall() {
  test::Place place{.name = "Hall", .low = {0.3, 0.3}, .high = {9.7, 5.7}, .reach = 12.0};
  test::addWalls(place.world, {{0, 0}, {10, 0}, {10, 6}, {0, 6}});
  place.world.add(sim::Box{1.4, 4.6, 0.0, 2.0, 1.6});
  return place;
}

TEST(KidnappingInAHall, ALookAlikeCornerIsNotTakenForTheRightOne) {
  for (const bool gyro : {false, true}) {
    Robot robot(nearlySymmetricHall(), {3.0, 2.0, 0.0});
    robot.gyro.there = gyro;
    robot.run(20.0, kCircle);
    ASSERT_EQ(robot.state(), LocalisationState::kLocalised);
    int wrong_poses = 0;
    robot.after_scan = [&] {
      wrong_poses += robot.error({3.0, 2.0, 0.0}) > kTold && robot.state() == LocalisationState::kLocalised;
    };
    robot.truth = {7.6, 4.2, robot.truth.theta + kPi + 0.7};  // from the other end
    robot.run(12.0, kCircle);
    EXPECT_EQ(wrong_poses, 0);
    if (gyro) {
      EXPECT_EQ(robot.state(), LocalisationState::kLost)
          << "it saw no turn, and the hall tells its ends apart by little";
    } else {
      EXPECT_EQ(robot.state(), LocalisationState::kLocalised);
      EXPECT_LT(robot.error({3.0, 2.0, 0.0}), 0.06);
    }
  }
}

TEST_P(Kidnapping, APersonWhoIsRightIsAccepted) {
  ASSERT_TRUE(driveUntilFound(6.0));
  robot.truth = kInB;
  robot.run(0.4, kCircle);
  robot.pipeline.setPose(between(kStart, robot.truth) * Pose2{0.2, -0.1, 0.1}, {0.2, 0.2, 0.1});
  robot.run(3.3, kCircle);
  EXPECT_EQ(robot.state(), LocalisationState::kLocalised);
  EXPECT_LT(robot.error(kStart), 0.05);
  EXPECT_EQ(robot.pipeline.backEnd().counters().placed, 2);
}

TEST_P(Kidnapping, APersonWhoIsWrongIsOverruled) {
  ASSERT_TRUE(driveUntilFound(6.0));
  robot.pipeline.setPose(between(kStart, robot.truth) * Pose2{3.0, 0.2, 0.0}, {0.2, 0.2, 0.1});
  for (int i = 0; i < 40 && !was_lost; ++i) robot.run(0.2, kCircle);
  EXPECT_TRUE(was_lost) << "the map says otherwise";
  wrong_poses = 0;  // until then the person's word counted
  ASSERT_TRUE(driveUntilFound(8.0));
  EXPECT_LT(robot.error(kStart), 0.05);
  robot.run(5.0, kCircle);
  EXPECT_LT(robot.error(kStart), 0.05);
  EXPECT_EQ(wrong_poses, 0);
}

INSTANTIATE_TEST_SUITE_P(InModes, Kidnapping, testing::Bool(),
                         [](const auto& mode) { return mode.param ? "Localise" : "Slam"; });

/// The flat, and a yard elsewhere that no map knows.
test::Place withUnknownYard() {
  test::Place place = flat();
  test::addWalls(place.world, {{20, -10}, {38, -8}, {36, 9}, {24, 12}, {19, 4}});
  place.world.add(sim::Box{31.0, 2.0, 0.5, 1.5, 1.0});
  place.world.add(sim::Box{26.0, -4.0, 0.2, 2.0, 0.6});
  place.world.add(sim::Box{27.5, 4.5, 1.0, 3.0, 0.5});
  place.world.add(sim::Cylinder{24.5, 0.5, 0.3});
  return place;
}

TEST(KidnappedRobot, IsLostWhereTheMapIsEmpty) {
  Robot robot(withUnknownYard(), kInA, false, given());
  robot.run(20.0, kCircle);
  ASSERT_EQ(robot.state(), LocalisationState::kLocalised);
  const int first = robot.pipeline.backEnd().keyframes().size(), drawn = robot.pipeline.mapper().keyframes();
  const OccupancyGrid grid = robot.pipeline.mapper().grid().clone();
  const auto sight = std::make_unique<DepthObservation>();
  const auto isDrawn = [&] { return robot.pipeline.backEnd().mapView(*sight).has_value(); };
  sight->session = robot.pipeline.frontEnd().session();
  sight->keyframe = first - 1;
  EXPECT_TRUE(isDrawn());
  robot.truth = {28.0, 0.0, 0.3};
  robot.run(3.0, {0, 0, 0});
  robot.after_scan = [&] { ASSERT_EQ(robot.state(), LocalisationState::kLost); };
  robot.run(12.0, kCircle);
  ASSERT_NE(robot.pipeline.frontEnd().session(), sight->session);
  EXPECT_FALSE(isDrawn()) << "an image of the robot before it got lost, which waited";
  sight->session = robot.pipeline.frontEnd().session();
  EXPECT_FALSE(isDrawn()) << "nor is one of the lost robot, wherever it thinks to be";
  EXPECT_GT(robot.pipeline.backEnd().keyframes().size(), first + 2);
  for (int id = first; id < robot.pipeline.backEnd().keyframes().size(); ++id)
    EXPECT_FALSE(robot.pipeline.backEnd().map().inMap(id)) << id;
  EXPECT_EQ(robot.pipeline.mapper().keyframes(), drawn);
  EXPECT_TRUE(test::sameCells(robot.pipeline.mapper().grid(), grid)) << "what an unfound robot sees is not drawn";
}

TEST(KidnappedRobot, BeginsAnewWhereTheMapWasHardlyBegun) {
  Robot robot(withUnknownYard(), kInA);
  robot.run(2.0, {0, 0, 0});  // switched on, then carried into the yard
  const int begun = robot.pipeline.backEnd().keyframes().size();
  robot.truth = {28.0, 0.0, 0.3};
  const Pose2 T_world_map = robot.truth * robot.estimate().T_map_base.inverse();
  robot.run(3.0, {0, 0, 0});
  ASSERT_EQ(robot.state(), LocalisationState::kLost);
  robot.run(12.0, kCircle);
  EXPECT_EQ(robot.state(), LocalisationState::kLocalised);
  EXPECT_LT(robot.error(T_world_map), 0.1);
  EXPECT_EQ(robot.pipeline.backEnd().counters().begun_anew, 1);
  EXPECT_EQ(robot.pipeline.backEnd().counters().placed, 0);
  for (int id = 0; id < robot.pipeline.backEnd().keyframes().size(); ++id)
    EXPECT_EQ(robot.pipeline.backEnd().map().inMap(id), id >= begun) << id;
  EXPECT_EQ(robot.pipeline.mapper().keyframes(), robot.pipeline.backEnd().keyframes().size() - begun);
}

TEST(KidnappedRobot, IsAcceptedWhereTheMapIsEmpty) {
  Robot robot(withUnknownYard(), kStart);
  robot.run(1.0, {0, 0, 0});
  robot.drive(8.0);
  robot.truth = {28.0, 0.0, 0.3};
  robot.pipeline.setPose(between(kStart, robot.truth), {0.2, 0.2, 0.1});
  robot.drive(4.0);
  EXPECT_EQ(robot.state(), LocalisationState::kLocalised);
  EXPECT_LT(robot.error(kStart), 0.1);
  EXPECT_EQ(robot.pipeline.backEnd().counters().placed, 1);
  const int newest = robot.pipeline.backEnd().keyframes().size() - 1;
  EXPECT_TRUE(robot.pipeline.backEnd().map().inMap(newest));
  const Eigen::Vector2d here = between(kStart, robot.truth).translation();
  EXPECT_LT(robot.pipeline.mapper().grid().logOdds(robot.pipeline.mapper().grid().cellAt(here)), 0)
      << "the yard is drawn";
}

TEST(KidnappedRobot, MayBeSetKilometresAwayAndComeBack) {
  const Pose2 far{9000.0, -9000.0, 0.3}, in_yard{28.0, 0.0, 0.3};
  Robot robot(withUnknownYard(), kStart);
  robot.run(1.0, {0, 0, 0});
  robot.drive(8.0);
  const int tiles = robot.pipeline.mapper().grid().tiles().tileCount();
  robot.truth = in_yard;
  robot.pipeline.setPose(far, {0.2, 0.2, 0.1});
  robot.drive(4.0);
  EXPECT_EQ(robot.state(), LocalisationState::kLocalised);
  EXPECT_LT(robot.error(in_yard * far.inverse()), 0.1);
  EXPECT_LT(robot.pipeline.mapper().grid().tiles().tileCount(), tiles + 200) << "of 18 million in a box around all";
  robot.truth = kInA;
  robot.pipeline.setPose(between(kStart, robot.truth), {0.2, 0.2, 0.1});
  robot.run(10.0, kCircle);
  EXPECT_EQ(robot.state(), LocalisationState::kLocalised);
  EXPECT_LT(robot.error(kStart), 0.05);
}

TEST(KidnappedRobot, TakesAGivenPoseInAnEmptyMap) {
  Robot robot(flat(), kStart);
  robot.pipeline.setPose({1.0, 2.0, 0.0}, {0.2, 0.2, 0.1});
  robot.run(1.0, {0, 0, 0});
  robot.drive(4.0);
  EXPECT_EQ(robot.state(), LocalisationState::kLocalised);
  EXPECT_LT(robot.error(kStart * Pose2{1.0, 2.0, 0.0}.inverse()), 0.1);
  EXPECT_TRUE(robot.pipeline.backEnd().map().inMap(0));
  EXPECT_GT(robot.pipeline.mapper().keyframes(), 5);
}

TEST(GivenMap, StaysAsItIsWhateverTheRobotMeets) {
  test::Place place = flat();
  place.world.add(sim::Box{4.2, 4.2, 0.4, 0.8, 0.6});  // put there since
  Robot robot(place, kInA, true, given());
  robot.run(20.0, kCircle);
  EXPECT_EQ(robot.state(), LocalisationState::kLocalised);
  for (const Pose2& thrown : {kInB, kInA, kInB}) {
    robot.truth = thrown;
    robot.run(20.0, kCircle);
  }
  robot.pipeline.setPose({0.0, 0.0, 1.0}, {0.2, 0.2, 0.1});
  robot.run(4.0, kCircle);
  EXPECT_GE(robot.pipeline.frontEnd().counters().lost, 4U);

  const MapState after = robot.pipeline.state();
  MapState part;
  const int size = given().keyframes.size();
  for (int id = 0; id < size; ++id) part.keyframes.add(after.keyframes.scan(id), after.keyframes.pose(id));
  for (const Edge& edge : after.keyframes.graph().edges()) {
    if (edge.from < size && edge.to < size) part.keyframes.graph().addEdge(edge);
  }
  part.in_map.assign(after.in_map.begin(), after.in_map.begin() + size);
  part.T_map_base = given().T_map_base;  // what the robot knows of itself may change
  part.gyro_bias = given().gyro_bias;
  part.T_base_lidar = given().T_base_lidar;
  part.range_max = given().range_max;
  EXPECT_EQ(test::differenceOf(part, given()), "");
  EXPECT_TRUE(test::sameCells(after.grid, given().grid));
  EXPECT_EQ(robot.pipeline.mapper().keyframes(), size);
  EXPECT_EQ(robot.pipeline.backEnd().generation(), 0);
}

}  // namespace
}  // namespace slam::kidnapping_test
