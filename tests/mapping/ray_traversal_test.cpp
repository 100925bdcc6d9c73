// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/ray_traversal.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace slam::ray_traversal_test {
namespace {

std::vector<CellIndex> ray(CellIndex from, CellIndex to) {
  std::vector<CellIndex> cells;
  traverseRay(from, to, [&](CellIndex cell) { cells.push_back(cell); });
  return cells;
}

TEST(TraverseRay, StepsAlongTheLineFromItsStartUpToItsEnd) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> coordinate(-200, 200);
  for (int i = 0; i < 1000; ++i) {
    const CellIndex from{coordinate(random), coordinate(random)}, to{coordinate(random), coordinate(random)};
    const int dx = to.column - from.column, dy = to.row - from.row;
    std::vector<CellIndex> cells = ray(from, to);
    ASSERT_EQ(cells.size(), static_cast<std::size_t>(std::max(std::abs(dx), std::abs(dy))));
    if (cells.empty()) continue;
    EXPECT_EQ(cells.front(), from);
    cells.push_back(to);
    const double length = std::hypot(dx, dy);
    for (std::size_t k = 0; k + 1 < cells.size(); ++k) {
      const int step_x = cells[k + 1].column - cells[k].column, step_y = cells[k + 1].row - cells[k].row;
      EXPECT_EQ(std::max(std::abs(step_x), std::abs(step_y)), 1);
      EXPECT_GE(step_x * dx, 0);
      EXPECT_GE(step_y * dy, 0);
      const double off_line = std::abs(dx * (cells[k].row - from.row) - dy * (cells[k].column - from.column)) / length;
      EXPECT_LE(off_line, 0.5 + 1e-9);
    }
  }
}

TEST(TraverseRay, IsTheSameWhereverItLies) {
  const auto here = ray({0, 0}, {17, -5});
  const auto there = ray({-1000, 400}, {-983, 395});
  ASSERT_EQ(here.size(), there.size());
  for (std::size_t i = 0; i < here.size(); ++i)
    EXPECT_EQ((CellIndex{here[i].column - 1000, here[i].row + 400}), there[i]);
}

TEST(TraverseRay, VisitsNothingWithinOneCell) { EXPECT_TRUE(ray({3, -4}, {3, -4}).empty()); }

}  // namespace
}  // namespace slam::ray_traversal_test
