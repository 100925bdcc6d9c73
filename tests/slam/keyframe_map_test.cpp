// SPDX-License-Identifier: BSD-3-Clause
#include "slam/keyframe_map.hpp"

#include <gmock/gmock.h>

#include "support/simulated/keyframes.hpp"

namespace slam::keyframe_map_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const Eigen::Vector3d kStep(0.002, 0.002, 0.0005);  // [m, m, rad]

class KeyframeMapTest : public testing::Test {
 protected:
  void add(bool in_map) { map.add(drive.at({0.1 * map.keyframes.size(), 0.0, 0.0}, kStep), in_map); }

  test::KeyframeDrive drive{test::furnishedRoom()};
  KeyframeMap map;
};

TEST_F(KeyframeMapTest, TheFrontEndHoldsWhatItMadeWhereTheGraphHasIt) {
  add(true);
  add(false);
  ASSERT_EQ(map.in_reference.size(), 2U);
  EXPECT_EQ(map.in_reference[1].T_map_base, map.keyframes.pose(1));
  EXPECT_TRUE(map.inReference(1));
  EXPECT_FALSE(map.inReference(2));
  EXPECT_THAT(map.in_map, ElementsAre(1, 0));
  EXPECT_THAT(map.idsInMap(), ElementsAre(0));
  EXPECT_EQ(map.newest(), 1);
}

TEST_F(KeyframeMapTest, ASessionBeginsWithAReferenceOfItsOwn) {
  add(true);
  add(true);
  const Keyframe& first = drive.at({3.0, 0.5, 0.0}, kStep);
  map.begin(first);
  ASSERT_EQ(map.in_reference.size(), 1U);
  EXPECT_EQ(map.in_reference[0].id, 2);
  EXPECT_EQ(map.in_reference[0].T_map_base, first.T_map_base);
  EXPECT_FALSE(map.inMap(2));
  EXPECT_EQ(map.keyframes.graph().edges().size(), 1U) << "joined to nothing";
}

TEST_F(KeyframeMapTest, GoesOnInAStoredMapAndBackToIt) {
  for (int i = 0; i < 3; ++i) add(true);
  KeyframeMap next;
  next.load(map.keyframes, {1, 0, 1});
  EXPECT_EQ(next.given, 3);
  EXPECT_THAT(next.idsInMap(), ElementsAre(0, 2));
  EXPECT_THAT(next.in_reference, IsEmpty()) << "the front end has none of them yet";
  next.begin(drive.at({}, kStep));
  ASSERT_EQ(next.in_map.size(), 4U);
  next.truncate();
  EXPECT_EQ(next.keyframes.size(), 3);
  EXPECT_THAT(next.in_map, ElementsAre(1, 0, 1));
  EXPECT_THAT(next.in_reference, IsEmpty());
}

TEST_F(KeyframeMapTest, ASessionThatIsTiedToItIsNoPartOfItUntilTheRobotHasDrivenOn) {
  add(true);
  add(true);
  map.begin(drive.at({0.5, 0.0, 0.0}, kStep));
  map.join = {.first = 2, .first_edge = 1, .remaining = 1.0, .p_robot = {0.5, 0.0}};
  add(true);
  EXPECT_THAT(map.idsInMap(), ElementsAre(0, 1));
  EXPECT_FALSE(map.join->driveTo({0.5, 0.6}));
  EXPECT_FALSE(map.join->driveTo({0.5, 0.6})) << "who stands drives nowhere";
  EXPECT_TRUE(map.join->driveTo({0.5, 0.1})) << "back is driven, too";
  map.confirmJoin();
  EXPECT_THAT(map.idsInMap(), ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(map.generation, 1);
  EXPECT_FALSE(map.undoJoin()) << "it stays";
  add(true);
  EXPECT_TRUE(map.inMap(4));
}

TEST_F(KeyframeMapTest, AnUndoneJoinLeavesTheSessionsOwnEdges) {
  add(true);
  add(true);
  map.begin(drive.at({0.5, 0.0, 0.0}, kStep));
  PoseGraph& graph = map.keyframes.graph();
  map.join = {.first = 2, .first_edge = 1, .remaining = 1.0, .p_robot = {0.5, 0.0}};
  graph.addEdge({.from = 0, .to = 2, .T_from_to = {}, .information = Eigen::Matrix3d::Identity()});
  add(true);
  PoseGraph copy = graph;
  map.join->revoke(copy);
  EXPECT_TRUE(copy.edges()[1].revoked);
  EXPECT_FALSE(graph.edges()[1].revoked);
  EXPECT_TRUE(map.undoJoin());
  EXPECT_FALSE(graph.edges()[0].revoked) << "of the map";
  EXPECT_TRUE(graph.edges()[1].revoked);
  ASSERT_EQ(graph.edges().size(), 3U);
  EXPECT_FALSE(graph.edges()[2].revoked) << "within the session";
  EXPECT_THAT(map.idsInMap(), ElementsAre(0, 1));
  EXPECT_FALSE(map.undoJoin());
}

/// Keyframes of a robot whose casing lies 0.3 m behind its lidar.
class CasedRobotTest : public KeyframeMapTest {
 protected:
  CasedRobotTest() { casing.millimetres[179] = casing.millimetres[180] = 300; }

  Keyframe& next(bool shows_casing) {
    keyframe = drive.at({0.1 * map.keyframes.size(), 0.0, 0.0}, kStep);
    if (shows_casing) keyframe.storage[static_cast<std::size_t>(keyframe.size++)] = {.x = -0.3F, .y = 0.0F};
    keyframe.body_margin = 0.1;
    return keyframe;
  }
  /// @return whether keyframes lost points to what is known with the next one
  bool know(const BodyShape& body) {
    next(false).body = body;
    const bool lost = map.leaveOut(keyframe);
    map.add(keyframe, true);
    return lost;
  }
  std::size_t points(int id) const { return map.keyframes.scan(id)->points.size(); }

  Keyframe keyframe;
  BodyShape casing;
};

TEST_F(CasedRobotTest, WhatTurnsOutToBeTheRobotLeavesTheScansSinceTheFirst) {
  map.add(next(true), true);
  map.add(next(true), true);
  const std::size_t before = points(0);
  EXPECT_FALSE(know({}));
  EXPECT_EQ(points(0), before);
  EXPECT_EQ(map.generation, 0);

  KeyframeMap cased;
  std::swap(cased, map);
  drive = test::KeyframeDrive(test::furnishedRoom());
  map.add(next(true), true);
  map.add(next(true), true);
  EXPECT_TRUE(know(casing));
  EXPECT_EQ(points(0), before - 1);
  EXPECT_EQ(points(1), cased.keyframes.scan(1)->points.size() - 1);
  EXPECT_EQ(map.generation, 1) << "it is drawn and stored anew";
  EXPECT_FALSE(map.reference_cleared) << "the front end has it still";
  EXPECT_FALSE(know(casing)) << "it is known already";
  BodyShape more = casing;
  more.millimetres[181] = 300;
  EXPECT_FALSE(know(more)) << "it left with the rest";
  EXPECT_EQ(map.generation, 1);
}

TEST_F(CasedRobotTest, WhatTheFirstScansDidNotShowStays) {  // a wall that it drives along, or a cart that came later
  map.add(next(false), true);
  map.add(next(true), true);
  const std::size_t before = points(1);
  EXPECT_FALSE(know(casing));
  EXPECT_EQ(points(1), before);
  EXPECT_EQ(map.generation, 0);
}

TEST_F(CasedRobotTest, MoreOfItIsLookedForBehindTheScansThatLostAPart) {
  BodyShape side;
  side.millimetres[90] = 300;
  const Keyframe::Point beside{.x = 0.0F, .y = 0.3F};
  for (const bool shows_casing : {true, false}) {  // the second was made when the casing behind was known
    Keyframe& made = next(shows_casing);
    made.storage[static_cast<std::size_t>(made.size++)] = beside;
    if (!shows_casing) made.body = casing;
    EXPECT_EQ(map.leaveOut(made), !shows_casing);
    map.add(made, true);
  }
  const std::size_t before = points(1);
  casing.millimetres[90] = 300;
  EXPECT_TRUE(know(casing));
  EXPECT_EQ(points(1), before - 1);
}

TEST_F(CasedRobotTest, AStoredMapStaysAsItIs) {
  map.add(next(true), true);
  KeyframeMap stored;
  stored.load(map.keyframes, {1});
  std::swap(map, stored);
  const std::size_t before = points(0);
  next(true).id = 1;
  map.begin(keyframe);
  EXPECT_TRUE(know(casing)) << "in the scan of this run";
  EXPECT_EQ(points(0), before);
}

}  // namespace
}  // namespace slam::keyframe_map_test
