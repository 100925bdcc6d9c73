// SPDX-License-Identifier: BSD-3-Clause
#include "matching/normals.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "matching/scanning.hpp"

namespace slam::normals_test {
namespace {

using test::Room;

TEST(Normals, ClaimTheVarianceTheyHave) {
  const Room corridor{.length = 1e6, .width = 2.0, .reach = 6.0, .range_sigma = 0.01};
  std::mt19937 random(1);
  double ratio = 0.0;
  int count = 0;
  for (int trial = 0; trial < 50; ++trial) {
    for (const ScanPoint& point : test::scanPoints(corridor, Pose2{}, random)) {
      if (!point.hasNormal()) continue;
      const double error = std::atan2(point.normal.x(), std::abs(point.normal.y()));
      ratio += error * error / point.normal_variance;
      ++count;
    }
  }
  EXPECT_GT(count, 5000);
  EXPECT_LT(ratio / count, 2.0);  // 1 for a perfect variance
  EXPECT_GT(ratio / count, 0.2);
}

TEST(Normals, LookTowardsTheLidarAndStandOnTheWalls) {
  std::mt19937 random(2);
  const Room room{};
  for (const ScanPoint& point : test::scanPoints(room, Pose2{}, random)) {
    if (!point.hasNormal()) continue;
    EXPECT_LT(point.normal.dot(point.position), 0.0);
    EXPECT_GT(point.normal.cwiseAbs().maxCoeff(), 0.9);
  }
}

TEST(Normals, StandOnTheWallsOfASparseScan) {
  for (const int beams : {60, 90, 180}) {
    std::mt19937 random(3);
    const Room room{.range_sigma = 0.01, .beams = beams};
    ScanPoints points = test::scanPoints(room, Pose2{}, random);
    EXPECT_NEAR(estimateNormals(points, Eigen::Vector2d::Zero()), 360.0 / beams, 0.1);
    EXPECT_NEAR(relativeSpacing(points, Eigen::Vector2d::Zero()), 360.0 / beams, 0.1);
    const auto lines = std::count_if(points.begin(), points.end(), [](const auto& p) { return p.hasNormal(); });
    EXPECT_GE(lines, beams - 4 * 3) << beams << ": all but the corners";
  }
}

TEST(Normals, AreMissingAtCornersAndAcrossGaps) {
  ScanPoints points;
  for (int i = 0; i < 10; ++i) points.push_back({.position = {1.0, 0.02 * i}, .range = 1.0});
  for (int i = 0; i < 10; ++i) points.push_back({.position = {1.0 + 0.02 * (i + 1), 0.18}, .range = 1.0});
  points.push_back({.position = {9.0, 9.0}, .range = 12.0});
  estimateNormals(points, Eigen::Vector2d::Zero());
  EXPECT_TRUE(points[2].hasNormal());
  EXPECT_TRUE(points[17].hasNormal());
  EXPECT_FALSE(points[9].hasNormal());   // the corner itself
  EXPECT_FALSE(points[20].hasNormal());  // alone
}

TEST(Normals, SpotsOfAWallSeenTooFlatMaySlide) {
  std::mt19937 random(4);
  for (const double sigma : {0.01, 0.02}) {
    int slides = 0, stays = 0;
    for (int trial = 0; trial < 20; ++trial) {
      const Room corridor{.length = 1e6, .width = 2.0, .reach = 12.0, .range_sigma = sigma};
      for (const ScanPoint& point : test::scanPoints(corridor, Pose2{}, random)) {
        if (point.range < 4.5) {
          EXPECT_FALSE(point.grazing) << point.range;
        }
        if (point.range < 6.0 || point.hasNormal()) continue;  // the first one's neighbour is near
        (point.grazing ? slides : stays) += 1;
      }
    }
    EXPECT_GT(slides, 300);
    EXPECT_LT(stays, slides / 20) << "all but a few whose noise hides the row";
  }
}

/// A motor does not turn evenly: 5 m along a corridor a tenth of a degree is 0.1 m of wall.
TEST(Normals, SpotsOfAWallMaySlideWhoseBearingsAreUneven) {
  std::mt19937 random(4);
  std::normal_distribution<double> jitter(0.0, 0.0017);  // [rad]
  int slides = 0, stays = 0;
  for (int trial = 0; trial < 40; ++trial) {
    ScanPoints points;
    for (int degrees = -40; degrees <= 40; ++degrees) {
      const double bearing = degrees * std::numbers::pi / 180.0;
      const double range = 1.0 / std::abs(std::sin(bearing + jitter(random)));  // the walls lie 1 m to either side
      if (range < 12.0)
        points.push_back({.position = range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing)), .range = range});
    }
    estimateNormals(points, Eigen::Vector2d::Zero());
    for (const ScanPoint& point : points) {
      if (point.range < 6.0 || point.hasNormal()) continue;
      (point.grazing ? slides : stays) += 1;
    }
  }
  EXPECT_GT(slides, 100);
  EXPECT_LT(stays, slides / 10);
}

TEST(Normals, WhatStandsAloneOrBeforeAWallDoesNotSlide) {
  ScanPoints points;
  const auto add = [&](double degrees, double range) {
    const double bearing = degrees * std::numbers::pi / 180.0;
    points.push_back({.position = range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing)), .range = range});
  };
  add(20, 5.0), add(19, 5.0), add(18, 5.0), add(17, 2.0), add(16, 5.0), add(15, 5.0), add(14, 5.0);  // a table's leg
  add(10, 4.0), add(8, 5.0), add(6, 12.0);  // further and further off
  estimateNormals(points, Eigen::Vector2d::Zero());
  EXPECT_FALSE(points[3].hasNormal());
  EXPECT_FALSE(points[9].hasNormal());
  for (const ScanPoint& point : points) EXPECT_FALSE(point.grazing) << point.range;
}

}  // namespace
}  // namespace slam::normals_test
