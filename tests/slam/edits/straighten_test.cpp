// SPDX-License-Identifier: BSD-3-Clause
#include "slam/edits/straighten.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::straighten_test {
namespace {

using testing::HasSubstr;
constexpr double kDegree = std::numbers::pi / 180.0;

/// A room of some size [m], turned in its map, whose points and normals are noisy; a tenth of them lie anywhere.
MapState turnedRoom(double angle, double width = 8.0, double height = 4.0) {
  std::mt19937 random(9);
  std::normal_distribution<double> noise(0.0, 0.03);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  MapState map;
  for (int id = 0; id < 10; ++id) {
    const Pose2 T_map_base{0.1 * id, 0.2, 0.3 * id};
    auto scan = std::make_shared<StoredScan>();
    for (int i = 0; i < 240; ++i) {
      const double along = uniform(random) * (width + height);
      const bool on_x = std::abs(along) < 0.5 * width;
      const Eigen::Vector2d p =
          on_x ? Eigen::Vector2d(along, i % 2 == 0 ? 0.5 * height : -0.5 * height)
               : Eigen::Vector2d(i % 2 == 0 ? 0.5 * width : -0.5 * width, uniform(random) * height);
      double normal = (on_x ? 0.5 * std::numbers::pi : 0.0) + (i % 2 == 0 ? std::numbers::pi : 0.0) + angle;
      normal += i % 10 == 0 ? 6.0 * uniform(random) : noise(random);
      const Eigen::Vector2d p_base = T_map_base.inverse() * (Pose2{0.0, 0.0, angle} * p);
      scan->points.push_back({static_cast<float>(p_base.x()), static_cast<float>(p_base.y()),
                              static_cast<std::int16_t>(std::lround(1e4 * wrapAngle(normal - T_map_base.theta))), 300});
    }
    map.keyframes.add(std::move(scan), T_map_base);
    map.in_map.push_back(1);
  }
  map.grid = OccupancyGrid(test::smallGrid());
  map.T_map_base = {1.0, 0.5, 0.2};
  return map;
}

TEST(Straighten, LevelsTheDominantWallsWithinAFifthOfADegree) {
  for (double degrees = -89.0; degrees < 90.0; degrees += 7.3) {
    const MapState map = turnedRoom(degrees * kDegree);
    const auto heading = headingOfWalls(map);
    ASSERT_TRUE(heading);
    EXPECT_NEAR(std::remainder(*heading - degrees * kDegree, std::numbers::pi), 0.0, 0.2 * kDegree) << degrees;
    const auto left = headingOfWalls(transformed(map, straightFrame(map, ""), test::smallGrid()));
    EXPECT_NEAR(*left, 0.0, 0.2 * kDegree) << degrees;
  }
}

TEST(Straighten, ASquareRoomIsNotTurnedByAQuarter) {
  for (const double degrees : {-30.0, 2.0, 40.0}) {
    const auto heading = headingOfWalls(turnedRoom(degrees * kDegree, 6.0, 6.0));
    ASSERT_TRUE(heading);
    EXPECT_NEAR(*heading, degrees * kDegree, 0.2 * kDegree);
  }
}

TEST(Straighten, PosesEditsAndRobotMoveAlong) {
  MapState map = turnedRoom(0.4);
  EditCommand dock = test::squareEdit(EditKind::kPlace, 0.7, 0.9);
  dock.request.points.resize(1);
  dock.request.name = "dock";
  dock.request.theta = 0.6;
  ASSERT_EQ(test::edit(map, dock), "");
  ASSERT_EQ(test::edit(map, test::squareEdit(EditKind::kErase, 0.0, 1.0)), "");
  const Pose2 T_new_map = straightFrame(map, "dock");
  const MapState next = transformed(map, T_new_map, test::smallGrid());
  EXPECT_NEAR((next.T_map_base.vector() - (T_new_map * map.T_map_base).vector()).norm(), 0.0, 1e-9);
  const Outline at = pointsOf(next.edits.edits[0], next.keyframes, next.in_map);
  EXPECT_NEAR(at[0].norm(), 0.0, 1e-9) << "the dock is the origin";
  const Outline before = pointsOf(map.edits.edits[1], map.keyframes, map.in_map),
                after = pointsOf(next.edits.edits[1], next.keyframes, next.in_map);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR((T_new_map * before[i] - after[i]).norm(), 0.0, 1e-9);
  for (int id = 0; id < map.keyframes.size(); ++id)
    EXPECT_EQ(next.keyframes.scan(id), map.keyframes.scan(id)) << "nothing is resampled";
  EXPECT_TRUE(test::sameCells(next.grid, test::drawn(next)));
}

TEST(Straighten, RefusesWithoutWallsOrPlace) {
  EXPECT_THAT(test::refusalOf([] { straightFrame(MapState(), ""); }), HasSubstr("too few walls"));
  EXPECT_THAT(test::refusalOf([] { straightFrame(turnedRoom(0.1), "dock"); }), HasSubstr("no place \"dock\""));
}

}  // namespace
}  // namespace slam::straighten_test
