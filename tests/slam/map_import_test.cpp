// SPDX-License-Identifier: BSD-3-Clause
#include "slam/map_import.hpp"

#include <gtest/gtest.h>

namespace slam::map_import_test {
namespace {

/// A room of 40 x 30 free cells of 0.1 m amid walls 4 cells thick, unknown around.
MapImage room() {
  MapImage image{.width = 60, .height = 50, .resolution = 0.1, .origin_x = -1.0, .origin_y = -2.0, .cells = {}};
  image.cells.assign(60 * 50, MapImage::kUnknown);
  for (int row = 6; row < 44; ++row) {
    for (int column = 6; column < 54; ++column) {
      const bool inside = row >= 10 && row < 40 && column >= 10 && column < 50;
      image.at(column, row) = inside ? MapImage::kFree : MapImage::kOccupied;
    }
  }
  return image;
}

TEST(MapImport, TakesFacesOfWallsWithNormalsTowardsFreeSpace) {
  const MapState map = importMap(room());
  EXPECT_EQ(map.kind, MapKind::kFloorPlan);
  int lines = 0, faces = 0;
  ScanPoints points;
  for (int id = 0; id < map.keyframes.size(); ++id) {
    map.keyframes.points(id, points);
    for (const ScanPoint& point : points) {
      ++faces;
      if (!point.hasNormal()) continue;
      ++lines;
      const Eigen::Vector2d p = map.keyframes.pose(id) * point.position, centre(2.0, 0.5);
      EXPECT_GT(point.normal.dot(centre - p), 0.0);
    }
  }
  EXPECT_EQ(faces, 2 * (40 + 30));
  EXPECT_GT(lines, faces * 9 / 10);
}

TEST(MapImport, DistinguishesWhatIsFreeFromWhatLiesWithinWalls) {
  const MapState map = importMap(room());
  std::size_t free = 0, solid = 0;
  for (int id = 0; id < map.keyframes.size(); ++id) {
    free += map.keyframes.scan(id)->free.size();
    solid += map.keyframes.scan(id)->solid.size();
  }
  EXPECT_EQ(free, 40u * 30u);
  EXPECT_EQ(solid, 48u * 38u - 40u * 30u - 2u * (40u + 30u));
}

}  // namespace
}  // namespace slam::map_import_test
