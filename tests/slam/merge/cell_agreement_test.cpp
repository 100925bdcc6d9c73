// SPDX-License-Identifier: BSD-3-Clause
#include "slam/merge/cell_agreement.hpp"

#include <gtest/gtest.h>

namespace slam::cell_agreement_test {
namespace {

constexpr LogOdds kOccupied = 800, kFree = -800;
constexpr double kTolerance = 0.15;  // [m] three cells

/// A room of 5 m by 5 m of free cells, with an obstacle of one cell.
OccupancyGrid room(CellIndex obstacle) {
  OccupancyGrid grid({.resolution = 0.05});
  for (int row = -50; row < 50; ++row) {
    for (int column = -50; column < 50; ++column) grid.set({column, row}, kFree);
  }
  grid.set(obstacle, kOccupied);
  return grid;
}

TEST(CellAgreement, IsOfCellsWithinTheTolerance) {
  const CellAgreement agreement = compareCells(room({-10, 5}), room({-7, 2}), kTolerance);
  EXPECT_EQ(agreement.same, 2) << "each grid's obstacle";
  EXPECT_EQ(agreement.different, 0);
  EXPECT_EQ(agreement.share(), 1.0);
}

TEST(CellAgreement, EndsBeyondTheTolerance) {
  const CellAgreement agreement = compareCells(room({-10, 5}), room({-6, 5}), kTolerance);
  EXPECT_EQ(agreement.same, 0);
  EXPECT_EQ(agreement.different, 2);
  EXPECT_EQ(agreement.share(), 0.0);
}

TEST(CellAgreement, CountsNothingThatTheOtherGridHasNotSeen) {
  OccupancyGrid wide = room({0, 0});
  wide.set({200, 0}, kOccupied);
  wide.set({49, 20}, kOccupied);  // beside the rim of the other one
  const CellAgreement agreement = compareCells(room({0, 0}), wide, kTolerance);
  EXPECT_EQ(agreement.same, 2);
  EXPECT_EQ(agreement.different, 0);
  EXPECT_EQ(compareCells(OccupancyGrid(), OccupancyGrid(), kTolerance).share(), 0.0) << "nothing is no agreement";
}

TEST(CellAgreement, CountsWhatStandsInOneGridAlone) {
  OccupancyGrid furnished = room({0, 0});
  furnished.set({20, 20}, kOccupied);
  for (const bool swapped : {false, true}) {
    const CellAgreement agreement =
        swapped ? compareCells(room({0, 0}), furnished, kTolerance) : compareCells(furnished, room({0, 0}), kTolerance);
    EXPECT_EQ(agreement.same, 2);
    EXPECT_EQ(agreement.different, 1);
  }
}

}  // namespace
}  // namespace slam::cell_agreement_test
