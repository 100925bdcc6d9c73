// SPDX-License-Identifier: BSD-3-Clause
#include "matching/scan_rows.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <memory>

namespace slam::scan_rows_test {
namespace {

ScanPoints numbered(int count) {
  ScanPoints points;
  for (int i = 0; i < count; ++i)
    points.push_back(
        {.position = {i, -i}, .normal = i % 3 == 0 ? Eigen::Vector2d(0.0, 0.0) : Eigen::Vector2d(0.6, 0.8)});
  return points;
}

TEST(ScanRows, HoldThePointsInOrderAndNameTheLanesThatAreEmpty) {
  for (const int count : {0, 1, 3, 4, 5, 4079, 4080}) {
    const ScanPoints points = numbered(count);
    const auto rows = std::make_unique<ScanRows>(points);
    ASSERT_EQ(rows->points(), points.size());
    int present = 0;
    for (std::size_t row = 0; row < rows->size(); ++row) {
      present += countOf(rows->present(row));
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::size_t i = row * kLanes + lane;
        ASSERT_EQ(rows->present(row)[lane] != 0, i < points.size());
        if (i >= points.size()) continue;
        EXPECT_EQ(rows->x(row)[lane], static_cast<float>(points[i].position.x()));
        EXPECT_EQ(rows->y(row)[lane], static_cast<float>(points[i].position.y()));
        EXPECT_EQ(rows->nx(row)[lane], static_cast<float>(points[i].normal.x()));
        EXPECT_EQ(rows->ny(row)[lane], static_cast<float>(points[i].normal.y()));
      }
    }
    EXPECT_EQ(present, count);
  }
}

TEST(ScanRows, HoldNoMoreThanAScan) {
  EXPECT_EQ(std::make_unique<ScanRows>(numbered(LaserScan::kCapacity + 5))->points(),
            static_cast<std::size_t>(LaserScan::kCapacity));
}

}  // namespace
}  // namespace slam::scan_rows_test
