// SPDX-License-Identifier: BSD-3-Clause
#include "slam/edits/map_edit.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

#include "support/stored_map.hpp"

namespace slam::map_edit_test {
namespace {

using testing::HasSubstr;

EditRequest square(EditKind kind, double x = 1.0, double y = 0.0, double side = 1.0) {
  EditRequest request;
  request.kind = kind;
  request.points = {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
  return request;
}

EditRequest circle(std::size_t corners) {
  EditRequest request;
  request.kind = EditKind::kFree;
  for (std::size_t i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(corners);
    request.points.emplace_back(std::cos(angle), std::sin(angle));
  }
  return request;
}

TEST(MapEdit, EveryKindHasAName) {
  for (int kind = 0; kind <= static_cast<int>(EditKind::kPlace); ++kind)
    EXPECT_EQ(editKindOf(nameOf(static_cast<EditKind>(kind))), static_cast<EditKind>(kind));
  EXPECT_EQ(editKindOf("paint"), std::nullopt);
}

TEST(MapEdit, RefusesOutlinesThatAreNone) {
  EXPECT_EQ(problemWith(square(EditKind::kErase)).words(), "");
  EXPECT_EQ(problemWith(circle(3)).words(), "");
  EXPECT_EQ(problemWith(circle(1000)).words(), "");
  EXPECT_THAT(problemWith(circle(1001)).words(), HasSubstr("at most 1000"));
  EXPECT_THAT(problemWith(circle(2)).words(), HasSubstr("three corners"));
  EditRequest bow = square(EditKind::kNoGo);
  std::swap(bow.points[1], bow.points[2]);
  EXPECT_THAT(problemWith(bow).words(), HasSubstr("crosses or touches itself"));
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e7}) {
    EditRequest request = square(EditKind::kFree);
    request.points[2].y() = bad;
    EXPECT_NE(problemWith(request).words(), "") << bad;
  }
}

TEST(MapEdit, RefusesNamesThatAreNone) {
  EditRequest room = square(EditKind::kRoom);
  EXPECT_THAT(problemWith(room).words(), HasSubstr("needs a name"));
  room.name = std::string(64, 'k');
  EXPECT_EQ(problemWith(room).words(), "");
  room.name += 'k';
  EXPECT_THAT(problemWith(room).words(), HasSubstr("65 bytes"));
  for (const char control : {'\n', '\0', '\x1b', '\x7f'}) {
    room.name = std::string("kit") + control;
    EXPECT_THAT(problemWith(room).words(), HasSubstr("control character"));
  }
  room.name =
      "K\xC3\xBC"
      "che";
  EXPECT_EQ(problemWith(room).words(), "");
}

TEST(MapEdit, APlaceIsAPoseWithASigma) {
  EditRequest place{.kind = EditKind::kPlace, .name = "dock", .author = "", .points = {{1.0, 2.0}}};
  place.theta = 1.0;
  EXPECT_EQ(problemWith(place).words(), "");
  place.theta = 90.0;
  EXPECT_THAT(problemWith(place).words(), HasSubstr("radians"));
  place.theta = 0.0;
  place.sigma.x() = -0.1;
  EXPECT_THAT(problemWith(place).words(), HasSubstr("sigma"));
  place.sigma.x() = std::nan("");
  EXPECT_THAT(problemWith(place).words(), HasSubstr("sigma"));
  place.points.emplace_back(0.0, 0.0);
  EXPECT_THAT(problemWith(place).words(), HasSubstr("one point"));
}

TEST(MapEdit, AWallIsALineOfTwoPointsOrMore) {
  EditRequest wall{.kind = EditKind::kWall, .name = "", .author = "", .points = {{0.0, 0.0}, {1.0, 0.0}}};
  EXPECT_EQ(problemWith(wall).words(), "");
  wall.points.emplace_back(1.0, 0.0);
  EXPECT_THAT(problemWith(wall).words(), HasSubstr("the same"));
  wall.points.resize(1);
  EXPECT_THAT(problemWith(wall).words(), HasSubstr("two points"));
}

TEST(MapEdit, LiesWhereItWasGivenAndMovesWithItsKeyframes) {
  test::ChangingMap changing(6);
  MapState& map = changing.map;
  const EditRequest request = square(EditKind::kFree);
  const auto edit = anchored(request, map.keyframes, map.in_map);
  ASSERT_TRUE(edit);
  const Outline before = pointsOf(*edit, map.keyframes, map.in_map);
  ASSERT_EQ(before.size(), request.points.size());
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR((before[i] - request.points[i]).norm(), 0.0, 1e-9);
  // The whole map turns and moves: so does the edit.
  const Pose2 T_new_old{3.0, -2.0, 1.2};
  for (int id = 0; id < map.keyframes.size(); ++id)
    map.keyframes.graph().setPose(id, T_new_old * map.keyframes.pose(id));
  const Outline after = pointsOf(*edit, map.keyframes, map.in_map);
  for (std::size_t i = 0; i < after.size(); ++i)
    EXPECT_NEAR((after[i] - T_new_old * request.points[i]).norm(), 0.0, 1e-9);
}

TEST(MapEdit, APlaceTurnsWithItsKeyframe) {
  test::ChangingMap changing(6);
  MapState& map = changing.map;
  EditRequest place{.kind = EditKind::kPlace, .name = "dock", .author = "", .points = {{0.5, 0.4}}};
  place.theta = 0.7;
  const auto edit = anchored(place, map.keyframes, map.in_map);
  ASSERT_TRUE(edit);
  const Pose2 T_new_old{3.0, -2.0, 1.2}, expected = T_new_old * Pose2{0.5, 0.4, 0.7};
  for (int id = 0; id < map.keyframes.size(); ++id)
    map.keyframes.graph().setPose(id, T_new_old * map.keyframes.pose(id));
  EXPECT_NEAR((poseOf(*edit, map.keyframes).vector() - expected.vector()).norm(), 0.0, 1e-9);
}

TEST(MapEdit, IsTiedToKeyframesOfTheMapAlone) {
  test::ChangingMap changing(4);
  MapState& map = changing.map;
  std::fill(map.in_map.begin(), map.in_map.end(), 0);
  EXPECT_FALSE(anchored(square(EditKind::kFree), map.keyframes, map.in_map));
  map.in_map[3] = 1;
  const auto edit = anchored(square(EditKind::kErase), map.keyframes, map.in_map);
  ASSERT_TRUE(edit);
  for (const MapEdit::Corner& corner : edit->corners) EXPECT_EQ(corner.keyframe, 3);
  EXPECT_EQ(edit->T_keyframe_map.size(), 1U);
  EXPECT_FALSE(anchored(square(EditKind::kFree, 500.0), map.keyframes, map.in_map));  // [m] far off
  map.in_map[3] = 0;
  EXPECT_TRUE(pointsOf(*edit, map.keyframes, map.in_map).empty());
}

}  // namespace
}  // namespace slam::map_edit_test
