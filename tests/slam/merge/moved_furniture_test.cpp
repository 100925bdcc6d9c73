// SPDX-License-Identifier: BSD-3-Clause
#include "slam/merge/moved_furniture.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace slam::moved_furniture_test {
namespace {

constexpr LogOdds kOccupied = 800, kFree = -800;
constexpr double kCell = 0.025;  // [m]

/// Two sides of a box that meet at a corner, as a lidar sees it.
struct Box {
  double x, y, yaw;      // [m, m, rad] of the corner
  double length, width;  // [m]
};

/// A room of 8 m by 8 m of free cells, in which boxes stand. What lies inside of them is unknown as far as
/// `hidden` [m] from x = -4.
OccupancyGrid room(const std::vector<Box>& boxes, double hidden = 0.0) {
  OccupancyGrid grid({.resolution = kCell});
  for (int row = -160; row < 160; ++row) {
    for (int column = -160 + static_cast<int>(std::lround(hidden / kCell)); column < 160; ++column)
      grid.set({column, row}, kFree);
  }
  for (const Box& box : boxes) {
    const Eigen::Rotation2Dd turn(box.yaw);
    const auto side = [&](const Eigen::Vector2d& along, double length) {
      for (double s = 0.0; s <= length; s += kCell)
        grid.set(grid.cellAt(Eigen::Vector2d(box.x, box.y) + turn * (s * along)), kOccupied);
    };
    side(Eigen::Vector2d::UnitX(), box.length);
    side(Eigen::Vector2d::UnitY(), box.width);
  }
  return grid;
}

MovedFurniture found(const std::vector<Box>& before, const std::vector<Box>& after) {
  return findMovedFurniture(room(before), room(after));
}

const Box kCupboard{-2.0, -1.0, 0.0, 1.2, 0.5}, kCrate{1.5, 1.0, 0.4, 0.6, 0.4};
constexpr double kOutline = 2 * 1.7 + 2 * 1.0;  // [m] of both, in both maps

TEST(MovedFurniture, IsNothingWhereAllStayed) {
  const MovedFurniture still = found({kCupboard, kCrate}, {kCupboard, kCrate});
  EXPECT_EQ(still.moved + still.turned + still.other, 0.0);
  EXPECT_EQ(still.evidence, 0.0);
}

TEST(MovedFurniture, IsWhatStandsNearByInTheSameShape) {
  Box cupboard = kCupboard, crate = kCrate;
  cupboard.x += 0.7, cupboard.y -= 0.6;
  crate.y += 0.8;
  const MovedFurniture moved = found({kCupboard, kCrate}, {cupboard, crate});
  EXPECT_NEAR(moved.moved + moved.turned + moved.other, kOutline, 0.2 * kOutline) << "a slanting side has fewer cells";
  EXPECT_GT(moved.moved, 5.0 * (moved.turned + moved.other));
  EXPECT_GT(moved.evidence, 3.0);
}

TEST(MovedFurniture, MayBeTurned) {
  Box cupboard = kCupboard, crate = kCrate;
  cupboard.x += 0.5, cupboard.yaw += 7 * MovedFurnitureConfig{}.turn;
  crate.x += 0.3, crate.yaw -= 5 * MovedFurnitureConfig{}.turn;
  const MovedFurniture turned = found({kCupboard, kCrate}, {cupboard, crate});
  EXPECT_GT(turned.turned, 2.0 * (turned.moved + turned.other));
  const double half = 0.5 * turned.turned;
  EXPECT_NEAR(turned.evidence, turned.moved + half - 0.75 * (half + turned.other), 1e-9)
      << "a turned piece counts half";
}

TEST(MovedFurniture, IsNotWhatStandsFarther) {
  Box cupboard = kCupboard, crate = kCrate;
  cupboard.x += 3.0;
  crate.y -= 2.5;
  const MovedFurniture far = found({kCupboard, kCrate}, {cupboard, crate});
  EXPECT_EQ(far.moved + far.turned, 0.0);
  EXPECT_NEAR(far.other, kOutline, 0.1 * kOutline);
}

TEST(MovedFurniture, IsNotWhatHasAnotherSize) {
  const MovedFurniture other = found({kCupboard, kCrate}, {{-1.5, -0.5, 0.0, 0.9, 0.8}, {1.2, 1.6, 0.1, 0.35, 0.7}});
  EXPECT_EQ(other.moved, 0.0);
  EXPECT_LT(other.evidence, -2.0);
}

TEST(MovedFurniture, HasOneTwinEach) {
  Box left = kCupboard, right = kCupboard;
  left.y -= 0.8, right.y += 0.8;
  const MovedFurniture twice = found({kCupboard}, {left, right});
  EXPECT_NEAR(twice.moved, 2 * 1.7, 0.2);
  EXPECT_NEAR(twice.other, 1.7, 0.2);
}

TEST(MovedFurniture, IsFoundWhereTheOtherMapHasSeenPartOfIt) {
  Box moved = kCupboard;
  moved.x -= 0.6, moved.y += 0.7;
  const double seen_from = 1.8;  // [m] from x = -4: 0.4 m of the long side are hidden before
  OccupancyGrid before = room({}, seen_from), whole = room({kCupboard});
  for (int row = -160; row < 160; ++row) {
    for (int column = -160 + 72; column < 160; ++column) before.set({column, row}, whole.logOdds({column, row}));
  }
  const MovedFurniture partial = findMovedFurniture(before, room({moved}));
  EXPECT_GT(partial.moved, 1.5);
  EXPECT_LT(partial.other, 0.5);
}

}  // namespace
}  // namespace slam::moved_furniture_test
