// SPDX-License-Identifier: BSD-3-Clause
#include "matching/range_image.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <utility>

#include "matching/scanning.hpp"

namespace slam::range_image_test {
namespace {

using enum RangeImage::Visibility;
using test::Room;

const Eigen::Vector2d kNoNormal = Eigen::Vector2d::Zero();

RangeImage imageOf(const Room& room, const Pose2& pose) {
  std::mt19937 random(1);
  RangeImage image;
  image.set(test::scanPoints(room, pose, random), Eigen::Vector2d::Zero());
  return image;
}

TEST(RangeImage, ShowsWhatTheScanSawThroughMetAndDidNotSee) {
  for (const int beams : {180, 360, 1440}) {
    const RangeImage image = imageOf({.length = 6.0, .width = 4.0, .range_sigma = 0.01, .beams = beams}, {});
    for (double angle = -3.1; angle < 3.1; angle += 0.1) {
      const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
      EXPECT_EQ(image.visibilityOf(1.5 * ray, kNoNormal), kViolated) << beams << " " << angle;
      EXPECT_EQ(image.visibilityOf(1.5 * ray, -ray), kViolated);
    }
    EXPECT_EQ(image.visibilityOf({3.02, 0.5}, {-1.0, 0.0}), kConsistent);
    EXPECT_EQ(image.visibilityOf({1.0, -1.95}, {0.0, 1.0}), kConsistent);
    EXPECT_EQ(image.visibilityOf({3.5, 0.5}, {-1.0, 0.0}), kOccluded);
    EXPECT_EQ(image.visibilityOf({30.0, 0.5}, {-1.0, 0.0}), kUnknown) << "further than anything seen";
    EXPECT_EQ(image.visibilityOf({1.5, 0.0}, {0.0, 1.0}), kUnknown) << "beams pass along such a wall";
    EXPECT_EQ(image.visibilityOf({0.0, 0.0}, kNoNormal), kViolated) << "the lidar is there";
  }
}

// Bins are the arc tangent's as long as this holds.
TEST(RangeImage, ARoughBearingIsNearTheArcTangent) {
  const int directions = 1000003;
  for (int i = 0; i < directions; ++i) {
    const double angle = 2.0 * M_PI * i / directions, range = 0.01 + i % 1000;
    const auto x = static_cast<float>(range * std::cos(angle)), y = static_cast<float>(range * std::sin(angle));
    ASSERT_NEAR(roughBearing(x, y), std::atan2(y, x), kRoughBearingError) << angle;
  }
  for (const auto& [x, y] :
       {std::pair(1.0F, 0.0F), {1.0F, -0.0F}, {0.0F, 1.0F}, {-0.0F, -1.0F}, {-1.0F, 0.0F}, {-1.0F, -0.0F}})
    EXPECT_NEAR(roughBearing(x, y), std::atan2(y, x), kRoughBearingError) << x << " " << y;
  EXPECT_TRUE(std::isnan(roughBearing(0.0F, 0.0F)));
}

TEST(RangeImage, IsUnknownWhereNoBeamReturned) {
  const RangeImage image = imageOf({.length = 40.0, .width = 2.0, .reach = 5.0, .range_sigma = 0.01}, {});
  EXPECT_EQ(image.visibilityOf({3.0, 0.0}, kNoNormal), kUnknown) << "along the corridor";
  EXPECT_EQ(image.visibilityOf({0.3, 0.5}, kNoNormal), kViolated);
  EXPECT_EQ(RangeImage().visibilityOf({1.0, 0.0}, kNoNormal), kUnknown);
}

TEST(RangeImage, ATallyLeavesOutWhatTheScanDoesNotShow) {
  VisibilityTally tally;
  EXPECT_EQ(tally.freeSpaceViolation(), 0.0);
  for (const auto sight : {kConsistent, kUnknown, kViolated, kOccluded, kConsistent, kConsistent}) tally.add(sight);
  EXPECT_EQ(tally.visible(), 4);
  EXPECT_EQ(tally.consistent, 3);
  EXPECT_EQ(tally.freeSpaceViolation(), 0.25);
}

TEST(RangeImage, LeavesAWallAloneThatItsErrorsMayPassBy) {
  const RangeImage image = imageOf({.length = 6.0, .width = 4.0}, {});
  // 5 cm within the corner, seen 2 degrees past it.
  const Eigen::Vector2d corner(2.95, 1.95);
  for (const double turn : {-0.015, 0.015}) {
    const Eigen::Vector2d p = Pose2{0.0, 0.0, turn} * corner;
    EXPECT_NE(image.visibilityOf(p, kNoNormal), kViolated);
  }
}

/// Beams all around at these distances from each other, of one range, seen from a lidar beside base.
RangeImage ring(double spacing, double range, const Eigen::Vector2d& lidar, bool clockwise) {
  ScanPoints points;
  for (double bearing = -3.1; bearing < 3.1; bearing += spacing) {
    points.push_back({.position = lidar + range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing))});
  }
  if (clockwise) std::reverse(points.begin(), points.end());
  RangeImage image;
  image.set(points, lidar);
  return image;
}

TEST(RangeImage, EachLimitHoldsFromBothSides) {
  const Eigen::Vector2d lidar(0.7, -0.4);
  for (const bool clockwise : {false, true}) {
    const RangeImage image = ring(0.02, 4.0, lidar, clockwise);
    const auto sight = [&](double range, const Eigen::Vector2d& normal = kNoNormal) {
      return image.visibilityOf(lidar + range * Eigen::Vector2d(0.6, 0.8), normal);
    };
    EXPECT_EQ(sight(3.75), kViolated);
    EXPECT_EQ(sight(3.85), kConsistent) << "20 cm before the wall";
    EXPECT_EQ(sight(4.15), kConsistent);
    EXPECT_EQ(sight(4.25), kUnknown) << "farther than anything seen";
    EXPECT_EQ(sight(0.15), kViolated) << "where the lidar is there is nothing else";
    EXPECT_EQ(sight(0.45), kViolated);
    const auto turned = [&](double cosine) {  // a wall's normal at this angle to the beam
      return sight(2.0, Pose2{0.0, 0.0, std::acos(cosine)} * Eigen::Vector2d(0.6, 0.8));
    };
    EXPECT_EQ(turned(0.27), kUnknown) << "beams pass along it";
    EXPECT_EQ(turned(0.33), kViolated);
    EXPECT_EQ(turned(-0.27), kUnknown);
    EXPECT_EQ(turned(-0.33), kViolated);
  }
  EXPECT_EQ(ring(0.055, 4.0, lidar, false).visibilityOf(lidar + Eigen::Vector2d(2.0, 0.03), kNoNormal), kViolated);
  EXPECT_EQ(ring(0.065, 4.0, lidar, false).visibilityOf(lidar + Eigen::Vector2d(2.0, 0.03), kNoNormal), kUnknown)
      << "what lies between beams so far apart was not seen";
}

TEST(RangeImage, ABeamWithoutReturnShowsFreeSpaceWhereNothingElseIsKnown) {
  RangeImage image;
  ScanPoints wall;
  for (double bearing = -0.5; bearing < 0.5; bearing += 0.02)
    wall.push_back({.position = 4.0 * Eigen::Vector2d(std::cos(bearing), std::sin(bearing))});
  image.set(wall, Eigen::Vector2d::Zero());
  for (double bearing = -1.5; bearing < 1.5; bearing += 0.02) image.setOpen(bearing, 0.02, 6.0);
  image.setOpen(2.5, 0.2, 6.0);  // beams too far apart to show it
  const auto sight = [&](double bearing, double range) {
    return image.visibilityOf(range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing)), kNoNormal);
  };
  EXPECT_EQ(sight(1.0, 5.0), kViolated);
  EXPECT_EQ(sight(1.0, 7.0), kUnknown) << "farther than it shows";
  EXPECT_EQ(sight(0.0, 4.0), kConsistent) << "the wall stays";
  EXPECT_EQ(sight(2.5, 2.0), kUnknown);
}

TEST(RangeImage, BetweenTwoBeamsTheNearerCounts) {
  ScanPoints points;
  for (int i = 0; i < 40; ++i) {
    const double bearing = 0.05 * i, range = i % 2 == 0 ? 2.0 : 4.0;
    points.push_back({.position = range * Eigen::Vector2d(std::cos(bearing), std::sin(bearing))});
  }
  RangeImage image;
  image.set(points, Eigen::Vector2d::Zero());
  for (double bearing = 0.3; bearing < 1.5; bearing += 0.01) {
    const Eigen::Vector2d ray(std::cos(bearing), std::sin(bearing));
    EXPECT_EQ(image.visibilityOf(1.5 * ray, kNoNormal), kViolated) << bearing;
    EXPECT_EQ(image.visibilityOf(3.0 * ray, kNoNormal), kOccluded) << bearing;
  }
}

}  // namespace
}  // namespace slam::range_image_test
