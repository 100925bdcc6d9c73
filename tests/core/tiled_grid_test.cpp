// SPDX-License-Identifier: BSD-3-Clause
#include "core/tiled_grid.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace slam::tiled_grid_test {
namespace {

using Grid = TiledGrid<int, 8>;
using Address = std::pair<int, int>;  // row, column: sorts like forEachTile()

int floorOf(int value) { return static_cast<int>(std::floor(value / 8.0)); }

TEST(TiledGrid, HoldsWhatAMapOfCellsWouldHold) {
  std::mt19937 random(1);
  std::normal_distribution<double> coordinate(0.0, 150.0);
  Grid grid;
  std::map<Address, int> cells;
  for (int i = 1; i <= 3000; ++i) {
    const CellIndex cell{static_cast<int>(coordinate(random)), static_cast<int>(coordinate(random))};
    grid.cell(cell) = i;
    cells[{cell.row, cell.column}] = i;
  }
  for (int row = -300; row <= 300; ++row) {
    for (int column = -300; column <= 300; ++column) {
      const auto found = cells.find({row, column});
      ASSERT_EQ(grid.read({column, row}), found == cells.end() ? 0 : found->second) << column << ' ' << row;
    }
  }
}

TEST(TiledGrid, TilesAreCountedAndVisitedOnceRowByRowFromTheLowerLeft) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> coordinate(-60, 60);
  Grid grid;
  std::set<Address> expected;
  for (int i = 0; i < 40; ++i) {
    const CellIndex cell{coordinate(random), coordinate(random)};
    grid.cell(cell) = 1;
    expected.insert({floorOf(cell.row), floorOf(cell.column)});
  }
  std::vector<Address> visited;
  grid.forEachTile([&](TileIndex index, const Grid::Tile& tile) {
    EXPECT_EQ(&tile, grid.find(index));
    visited.push_back({index.row, index.column});
  });
  EXPECT_EQ(visited, std::vector<Address>(expected.begin(), expected.end()));
  EXPECT_EQ(grid.tileCount(), static_cast<int>(expected.size()));
}

TEST(TiledGrid, TileAddressesAreRoundedDown) {
  for (int value = -40; value <= 40; ++value)
    EXPECT_EQ(Grid::tileOf({value, -value}), (TileIndex{floorOf(value), floorOf(-value)}));
}

TEST(TiledGrid, GrowingInAnyDirectionMovesNoCell) {
  Grid grid;
  const int* const first = &(grid.cell({3, 4}) = 7);
  for (const CellIndex far : {CellIndex{1000, 0}, {-1000, 0}, {0, 1000}, {0, -1000}, {-1500, 1500}}) {
    grid.cell(far) = 1;
    EXPECT_EQ(&grid.cell({3, 4}), first);
    EXPECT_EQ(*first, 7);
  }
}

TEST(TiledGrid, TilesThatLieFarApartTakeTheMemoryOfTiles) {
  constexpr int kFar = 1 << 27;  // a box around them would have 1e15 tiles
  Grid grid;
  const CellIndex corners[] = {{kFar, kFar}, {-kFar, kFar}, {0, 0}, {-kFar, -kFar}, {kFar, -kFar}};
  int value = 0;
  for (const CellIndex& cell : corners) grid.cell(cell) = ++value;
  const Grid copy = grid.clone();
  std::vector<int> visited;
  copy.forEachTile([&](TileIndex, const Grid::Tile& tile) { visited.push_back(tile.at(0, 0)); });
  EXPECT_EQ(visited, (std::vector<int>{4, 5, 3, 2, 1}));
  EXPECT_EQ(copy.tileCount(), 5);
}

TEST(TiledGrid, TilesAreTakenOutRowByRowAndPutIntoAnother) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> coordinate(-90, 90);
  Grid from, to;
  to.cell({0, 0}) = -1;
  std::map<Address, int> expected{{{0, 0}, -1}};
  for (int i = 1; i <= 60; ++i) {
    const TileIndex tile{coordinate(random), coordinate(random)};
    from.make(tile).at(0, 0) = i;
    expected[{tile.row, tile.column}] = i;
  }
  std::vector<Address> taken;
  from.takeTiles([&](TileIndex tile, std::unique_ptr<Grid::Tile> content) {
    taken.push_back({tile.row, tile.column});
    to.put(tile, std::move(content));
  });
  EXPECT_TRUE(std::is_sorted(taken.begin(), taken.end()));
  EXPECT_EQ(from.tileCount(), 0);
  from.cell({8, 8}) = 5;
  EXPECT_EQ(from.tileCount(), 1);
  std::map<Address, int> found;
  to.forEachTile([&](TileIndex tile, const Grid::Tile& content) { found[{tile.row, tile.column}] = content.at(0, 0); });
  EXPECT_EQ(found, expected);
  EXPECT_EQ(to.tileCount(), static_cast<int>(expected.size()));
}

TEST(TiledGrid, ReadingMakesNothing) {
  const Grid empty;
  EXPECT_EQ(empty.read({-5, 5}), 0);
  EXPECT_EQ(empty.find({0, 0}), nullptr);
  EXPECT_EQ(empty.tileCount(), 0);

  Grid grid;
  grid.cell({0, 0}) = 1;
  EXPECT_EQ(grid.read({100, -100}), 0);
  EXPECT_EQ(grid.find({12, -13}), nullptr);
  EXPECT_EQ(grid.tileCount(), 1);
}

TEST(TiledGrid, MakeGivesTheSameTileAgain) {
  Grid grid;
  Grid::Tile& tile = grid.make({-2, 3});
  tile.at(1, 2) = 9;
  EXPECT_EQ(&grid.make({-2, 3}), &tile);
  EXPECT_EQ(grid.tileCount(), 1);
  EXPECT_EQ(grid.read({-2 * 8 + 1, 3 * 8 + 2}), 9);
}

TEST(TiledGrid, ClearForgetsEverything) {
  Grid grid;
  grid.cell({-9, 9}) = 5;
  grid.clear();
  EXPECT_EQ(grid.tileCount(), 0);
  EXPECT_EQ(grid.read({-9, 9}), 0);
  grid.cell({20, 20}) = 6;  // and starts again elsewhere
  EXPECT_EQ(grid.tileCount(), 1);
  EXPECT_EQ(grid.read({20, 20}), 6);
}

}  // namespace
}  // namespace slam::tiled_grid_test
