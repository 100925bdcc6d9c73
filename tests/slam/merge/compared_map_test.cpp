// SPDX-License-Identifier: BSD-3-Clause
#include "slam/merge/compared_map.hpp"

#include <gtest/gtest.h>

namespace slam::compared_map_test {
namespace {

using Look = ComparedMap::Look;

constexpr LogOdds kOccupied = 800, kFree = -800;
constexpr double kCell = 0.025;  // [m]

/// A room of 5 m by 5 m of free cells with a wall along its south side.
OccupancyGrid room() {
  OccupancyGrid grid({.resolution = kCell});
  for (int row = -100; row < 100; ++row) {
    for (int column = -100; column < 100; ++column) grid.set({column, row}, row == -100 ? kOccupied : kFree);
  }
  return grid;
}

/// The same with the side of a piece along x, of so many cells.
OccupancyGrid roomWith(CellIndex from, int length) {
  OccupancyGrid grid = room();
  for (int i = 0; i < length; ++i) grid.set({from.column + i, from.row}, kOccupied);
  return grid;
}

ComparedMap compared(const OccupancyGrid& grid, const OccupancyGrid& other) {
  ComparedMap map(grid);
  map.compareWith(ComparedMap(other));
  return map;
}

TEST(ComparedMap, FindsThePieceThatStandsInOneMapAlone) {
  const ComparedMap map = compared(roomWith({10, 20}, 40), room());
  EXPECT_EQ(map.alone(), 40);
  ASSERT_EQ(map.pieces().size(), 2u) << "as what stands alone, and as what differs";
  for (const Piece& piece : map.pieces()) {
    EXPECT_EQ(piece.cells.size(), 40u);
    EXPECT_EQ(piece.alone, 40);
    EXPECT_EQ(piece.side(), 39);
    EXPECT_EQ(piece.low, (CellIndex{10, 20}));
  }
  EXPECT_EQ(compared(room(), roomWith({10, 20}, 40)).alone(), 0) << "the other map has none";
}

TEST(ComparedMap, LeavesOutWhatStandsWithinTheToleranceInBoth) {
  EXPECT_EQ(compared(roomWith({10, 20}, 40), roomWith({10, 26}, 40)).alone(), 0);
  EXPECT_EQ(compared(roomWith({10, 20}, 40), roomWith({10, 27}, 40)).alone(), 40);
}

TEST(ComparedMap, LeavesOutWhatIsTooSmallToBeRecognised) {
  EXPECT_TRUE(compared(roomWith({10, 20}, 8), room()).pieces().empty());
  EXPECT_FALSE(compared(roomWith({10, 20}, 9), room()).pieces().empty()) << "0.2 m";
}

TEST(ComparedMap, PutsCellsWithinTheGapIntoOnePiece) {
  OccupancyGrid grid = roomWith({10, 20}, 20);
  for (int i = 0; i < 20; ++i) grid.set({33 + i, 20}, kOccupied);  // 3 cells between
  EXPECT_EQ(compared(grid, room()).pieces().front().cells.size(), 40u);
  grid = roomWith({10, 20}, 20);
  for (int i = 0; i < 20; ++i) grid.set({34 + i, 20}, kOccupied);
  EXPECT_EQ(compared(grid, room()).pieces().front().cells.size(), 20u);
}

TEST(ComparedMap, LeavesOutWhatTheOtherMapHasNotSeenAtAWallOfBoth) {
  OccupancyGrid grid = room();
  for (int i = 0; i < 60; ++i) grid.set({100 + i, -100}, kOccupied);  // the wall goes on where the other has not been
  EXPECT_TRUE(compared(grid, room()).pieces().empty());
  grid = room();
  for (int i = 0; i < 60; ++i) grid.set({110 + i, 0}, kOccupied);  // a piece there
  const ComparedMap map = compared(grid, room());
  ASSERT_EQ(map.pieces().size(), 1u);
  EXPECT_EQ(map.pieces().front().alone, 0) << "nothing there contradicts the other map";
}

TEST(ComparedMap, LooksLikeAnObstacleWhereTheOtherMapHasNone) {
  OccupancyGrid grid = roomWith({10, 20}, 40);
  const ComparedMap map = compared(grid, room());
  EXPECT_EQ(map.look({20, 20}), Look::kObstacle);
  EXPECT_EQ(map.look({20, 22}), Look::kObstacle) << "blurred by 0.05 m";
  EXPECT_EQ(map.look({20, 23}), Look::kNone);
  EXPECT_EQ(map.look({20, -100}), Look::kNone) << "a wall of both";
  EXPECT_EQ(map.look({20, 300}), Look::kUnseen);
}

}  // namespace
}  // namespace slam::compared_map_test
