// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/truth_map.hpp"

#include <gtest/gtest.h>

namespace slam::sim::truth_map_test {
namespace {

constexpr HeightBand kBand{0.05, 0.80}, kPlane{0.16, 0.20};

/// A wall at x = 4 and, before it, a table top over x in [1.5, 2.5].
World tableBeforeAWall() {
  World world;
  world.addWall({4.05, -2.0}, {4.05, 2.0});
  world.add(Box{2.0, 0.0, 0.0, 1.0, 1.0, 0.70, 0.74});
  world.add(Cylinder{-1.0, 0.0, 0.05, 0.0, 1.0});
  return world;
}

std::uint8_t at(const MapImage& image, double x, double y) {
  return image.at(static_cast<int>(std::floor((x - image.origin_x) / image.resolution)),
                  static_cast<int>(std::floor((y - image.origin_y) / image.resolution)));
}

/// A table before a wall, of which the lidar has sent one ray to the wall.
struct RayToTheWall {
  World world = tableBeforeAWall();
  TruthMap map;
  explicit RayToTheWall(const HeightBand& band) : map(world, band, kPlane) { map.seeRay({0.0, 0.02}, 0.0, 4.0); }
};

TEST(TruthMap, WhatOnlyARayPassedUnderIsNotKnown) {
  const MapImage image = RayToTheWall(kBand).map.image();
  EXPECT_EQ(at(image, 1.0, 0.02), MapImage::kFree);
  EXPECT_EQ(at(image, 2.0, 0.02), MapImage::kUnknown);
  EXPECT_EQ(at(image, 3.0, 0.02), MapImage::kFree);
  EXPECT_EQ(at(image, 4.02, 0.02), MapImage::kOccupied);
  EXPECT_EQ(at(image, 1.0, 0.52), MapImage::kUnknown);
}

TEST(TruthMap, WhatACameraSawOfATopIsOccupied) {
  RayToTheWall seen(kBand);
  TruthMap& map = seen.map;
  map.seeSurface({1.5, 0.02}, {1.0, 0.0});
  map.seeSurface({1.0, 0.02}, {1.0, 0.0});  // someone who has left since
  map.seeSurface({1.0, 0.52}, {1.0, 0.0});
  map.seeFloor({2.2, 0.02});
  map.seeFloor({0.5, 0.52});
  const MapImage image = map.image();
  EXPECT_EQ(at(image, 1.52, 0.02), MapImage::kOccupied);
  EXPECT_EQ(at(image, 2.22, 0.02), MapImage::kUnknown);
  EXPECT_EQ(at(image, 1.0, 0.02), MapImage::kFree);
  EXPECT_EQ(at(image, 1.0, 0.52), MapImage::kUnknown);
  EXPECT_EQ(at(image, 0.52, 0.52), MapImage::kFree);
}

TEST(TruthMap, OfTheScannedPlaneAloneHasTheTableFree) {
  const MapImage image = RayToTheWall(kPlane).map.image();
  EXPECT_EQ(at(image, 2.0, 0.02), MapImage::kFree);
  EXPECT_EQ(at(image, 4.02, 0.02), MapImage::kOccupied);
}

}  // namespace
}  // namespace slam::sim::truth_map_test
