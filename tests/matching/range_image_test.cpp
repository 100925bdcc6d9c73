// SPDX-License-Identifier: BSD-3-Clause
#include "matching/range_image.hpp"

#include <gtest/gtest.h>
#include <random>

#include "matching/scanning.hpp"

namespace slam {
namespace {

using enum RangeImage::Sight;
using test::Room;

const Eigen::Vector2d kNoNormal = Eigen::Vector2d::Zero();

RangeImage imageOf(const Room& room, const Pose2& pose) {
  std::mt19937 random(1);
  RangeImage image;
  image.set(test::scanPoints(room, pose, random), Eigen::Vector2d::Zero());
  return image;
}

TEST(RangeImage, TellsWhatTheScanSawThroughMetAndDidNotSee) {
  for (const int beams : {180, 360, 1440}) {
    const RangeImage image = imageOf({.length = 6.0, .width = 4.0, .range_sigma = 0.01, .beams = beams}, {});
    for (double angle = -3.1; angle < 3.1; angle += 0.1) {
      const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
      EXPECT_EQ(image.sightOf(1.5 * ray, kNoNormal), kSeenThrough) << beams << " " << angle;
      EXPECT_EQ(image.sightOf(1.5 * ray, -ray), kSeenThrough);
    }
    EXPECT_EQ(image.sightOf({3.02, 0.5}, {-1.0, 0.0}), kMet);
    EXPECT_EQ(image.sightOf({1.0, -1.95}, {0.0, 1.0}), kMet);
    EXPECT_EQ(image.sightOf({3.5, 0.5}, {-1.0, 0.0}), kHidden);
    EXPECT_EQ(image.sightOf({30.0, 0.5}, {-1.0, 0.0}), kUnknown) << "further than anything seen";
    EXPECT_EQ(image.sightOf({1.5, 0.0}, {0.0, 1.0}), kUnknown) << "beams pass along such a wall";
    EXPECT_EQ(image.sightOf({0.0, 0.0}, kNoNormal), kUnknown);
  }
}

TEST(RangeImage, KnowsNothingWhereNoBeamReturned) {
  const RangeImage image = imageOf({.length = 40.0, .width = 2.0, .reach = 5.0, .range_sigma = 0.01}, {});
  EXPECT_EQ(image.sightOf({3.0, 0.0}, kNoNormal), kUnknown) << "along the corridor";
  EXPECT_EQ(image.sightOf({0.3, 0.5}, kNoNormal), kSeenThrough);
  EXPECT_EQ(RangeImage().sightOf({1.0, 0.0}, kNoNormal), kUnknown);
}

TEST(RangeImage, ATallyLeavesOutWhatTheScanDoesNotTell) {
  SightTally tally;
  EXPECT_EQ(tally.seenThrough(), 0.0);
  for (const auto sight : {kMet, kUnknown, kSeenThrough, kHidden, kMet, kMet}) tally.add(sight);
  EXPECT_EQ(tally.told(), 4);
  EXPECT_EQ(tally.met, 3);
  EXPECT_EQ(tally.seenThrough(), 0.25);
}

TEST(RangeImage, LeavesAWallAloneThatItsErrorsMayPassBy) {
  const RangeImage image = imageOf({.length = 6.0, .width = 4.0}, {});
  // 5 cm within the corner, seen 2 degrees past it.
  const Eigen::Vector2d corner(2.95, 1.95);
  for (const double turn : {-0.015, 0.015}) {
    const Eigen::Vector2d p = Pose2{0.0, 0.0, turn} * corner;
    EXPECT_NE(image.sightOf(p, kNoNormal), kSeenThrough);
  }
}

}  // namespace
}  // namespace slam
