// SPDX-License-Identifier: BSD-3-Clause
#include "slam/floor_decision.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <vector>

#include "slam/map_builder.hpp"
#include "support/simulated/mapped_drive.hpp"

namespace slam::test::floor_decision_test {
namespace {

constexpr int kBuilding = 1;  // seed of the scene: its floors have the same walls

Place floorPlace(int floor) {
  return {.name = "Floor",
          .low = {},
          .high = {},
          .reach = 12.0,
          .world = sim::makeScene("homes", kBuilding, {.floor = floor}).world};
}

/// Along the corridor and through all rooms, which is free on all floors.
std::vector<Pose2> throughAllRooms() {
  std::vector<Pose2> poses{Pose2{}};
  for (const sim::Waypoint& waypoint : sim::makeScene("homes", kBuilding).route) {
    const Eigen::Vector2d from = poses.back().translation(), way = waypoint.pose.translation() - from;
    for (double s = 0.3; s < way.norm(); s += 0.3) {
      const Eigen::Vector2d p = from + s / way.norm() * way;
      poses.push_back({p.x(), p.y(), std::atan2(way.y(), way.x())});
    }
  }
  return poses;
}

MapState floorMap(int floor) { return mapped(floorPlace(floor), throughAllRooms(), static_cast<unsigned>(floor)).map; }

/// A robot that begins in the map of one floor without its place, and may be on any.
class Robot {
 public:
  Robot(int present, const std::vector<int>& others, int on) : drive_(floorPlace(on), static_cast<unsigned>(100 + on)) {
    MapState map = floorMap(present);
    map.floors.present = name(present);
    for (const int other : others) {
      MapState more = floorMap(other);
      map.floors.others.push_back(
          std::make_shared<const FloorMap>(FloorMap{name(other), std::move(more.keyframes), std::move(more.in_map)}));
    }
    BackEndConfig config;
    config.localise_only = true;
    given_ = map.keyframes.size();
    builder_ = std::make_unique<MapBuilder>(config, map);
  }
  static std::string name(int floor) { return "floor-" + std::to_string(floor); }

  MapUpdate at(const Pose2& truth) {
    auto keyframe = std::make_unique<Keyframe>(drive_.at(truth, {0.002, 0.002, 0.0005}));
    keyframe->id += given_;
    keyframe->session = 1;
    keyframe->origin = driven_++ == 0 ? origin : KeyframeOrigin::kContinued;
    builder_->allowFor(1000);
    return builder_->add(*keyframe);
  }
  /// Drives until a map is decided for. @return its name; empty: none within the poses
  std::string drive(const std::vector<Pose2>& poses, std::size_t begin) {
    for (std::size_t i = begin; i < poses.size(); ++i) {
      const MapUpdate update = at(poses[i]);
      refuted |= update.correction && update.correction->refuted;
      if (update.relocalised) return "present";
      if (!update.elsewhere) continue;
      T_truth = poses[i];
      T_found = update.elsewhere->T_floor_session * builder_->backEnd().keyframes().pose(given_ + driven_ - 1);
      return update.elsewhere->name;
    }
    return "";
  }
  std::vector<std::string> doubt() const {
    std::vector<std::string> names;
    for (const FloorFound& floor : builder_->backEnd().floorDoubt()) names.push_back(floor.name);
    return names;
  }
  /// Where the newest keyframe is in each map of which it may be.
  std::vector<Pose2> doubtfulPlaces() const {
    std::vector<Pose2> places;
    for (const FloorFound& floor : builder_->backEnd().floorDoubt())
      places.push_back(floor.T_floor_session * builder_->backEnd().keyframes().pose(given_ + driven_ - 1));
    return places;
  }
  int driven() const { return driven_; }

  Pose2 T_truth, T_found;
  KeyframeOrigin origin = KeyframeOrigin::kLost;  // of the session
  bool refuted = false;

 private:
  KeyframeDrive drive_;
  std::unique_ptr<MapBuilder> builder_;
  int given_ = 0, driven_ = 0;
};

TEST(FloorDecision, FindsTheFloorByItsFurniture) {
  const std::vector<Pose2> way = throughAllRooms();
  for (const std::size_t begin : {std::size_t{0}, way.size() / 3, way.size() / 2}) {
    Robot robot(1, {2, 3}, 3);
    ASSERT_EQ(robot.drive(way, begin), "floor-3") << begin;
    const Pose2 error = between(robot.T_truth, robot.T_found);
    EXPECT_LT(std::hypot(error.x, error.y), 0.2) << begin;
    EXPECT_GT(robot.driven(), 1) << "one scan decides nothing";
  }
}

TEST(FloorDecision, FindsTheRobotInThePresentMapAsBefore) {
  Robot robot(2, {1, 3}, 2);
  EXPECT_EQ(robot.drive(throughAllRooms(), 0), "present");
  EXPECT_TRUE(robot.doubt().empty());
}

TEST(FloorDecision, NamesTheMapsThatAreAlikeAndDecidesForNone) {
  Robot robot(1, {1, 3}, 1);  // a copy of it
  std::vector<Pose2> way = throughAllRooms();
  way.resize(way.size() / 2);
  EXPECT_EQ(robot.drive(way, 0), "");
  EXPECT_EQ(robot.doubt(), (std::vector<std::string>{"floor-1", "floor-1"}));
}

TEST(FloorDecision, SearchesAllMapsForASessionBehindALift) {
  const std::vector<Pose2> way = throughAllRooms();
  Robot up(1, {2, 3}, 3), back(1, {2, 3}, 1), nowhere(1, {2}, 4);
  for (Robot* robot : {&up, &back, &nowhere}) robot->origin = KeyframeOrigin::kAssumed;
  EXPECT_EQ(up.drive(way, 0), "floor-3");
  EXPECT_FALSE(up.refuted) << "where it was assumed, until another map is loaded";
  EXPECT_EQ(back.drive(way, 0), "present");
  EXPECT_FALSE(back.refuted);
  EXPECT_EQ(nowhere.drive(way, 0), "");
  EXPECT_TRUE(nowhere.refuted) << "it is lost on a floor that none of the maps shows";
}

TEST(FloorDecision, GivesThePlaceInEachMapThatIsAlike) {
  Robot robot(1, {1}, 1);
  robot.origin = KeyframeOrigin::kAssumed;
  std::vector<Pose2> way = throughAllRooms();
  way.resize(way.size() / 2);
  EXPECT_EQ(robot.drive(way, 0), "");
  EXPECT_FALSE(robot.refuted);
  const std::vector<Pose2> places = robot.doubtfulPlaces();
  ASSERT_EQ(places.size(), 2U);
  for (const Pose2& place : places) EXPECT_LT((place.translation() - way.back().translation()).norm(), 0.3);
}

TEST(FloorDecision, FindsNoFloorOnOneThatIsNotAmongTheMaps) {
  Robot robot(1, {2}, 4);
  std::vector<Pose2> way = throughAllRooms();
  way.resize(way.size() / 2);
  EXPECT_EQ(robot.drive(way, 0), "");
}

}  // namespace
}  // namespace slam::test::floor_decision_test
