// SPDX-License-Identifier: BSD-3-Clause
#include "slam/edits/edit_export.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/stored_map.hpp"

namespace slam::edit_export_test {
namespace {

MapImage image() {
  MapImage image;
  image.width = 60;
  image.height = 40;
  image.resolution = 0.1;
  image.origin_x = -1.0;
  image.origin_y = -1.0;
  image.cells.assign(60 * 40, MapImage::kUnknown);
  return image;
}

/// [m] in map
std::uint8_t at(const MapImage& image, double x, double y) {
  return image.at(static_cast<int>((x - image.origin_x) / image.resolution),
                  static_cast<int>((y - image.origin_y) / image.resolution));
}

TEST(EditExport, TheMaskHoldsZonesAndWallsAlone) {
  test::ChangingMap changing(5);
  ASSERT_EQ(test::edit(changing.map, test::squareEdit(EditKind::kNoGo, 1.0, 0.5)), "");
  ASSERT_EQ(test::edit(changing.map, test::squareEdit(EditKind::kFree, 3.0, 0.5)), "");
  EditCommand wall = test::squareEdit(EditKind::kWall, 0.0, 0.0);
  wall.request.points = {{-0.5, 2.02}, {4.0, 2.02}};
  ASSERT_EQ(test::edit(changing.map, wall), "");
  const MapImage mask = keepOutMask(changing.map, image());
  EXPECT_EQ(at(mask, 1.55, 1.05), MapImage::kOccupied);
  EXPECT_EQ(at(mask, 2.55, 1.05), MapImage::kFree);
  EXPECT_EQ(at(mask, 3.55, 1.05), MapImage::kFree);
  EXPECT_EQ(at(mask, 0.05, 2.02), MapImage::kOccupied);
  EXPECT_EQ(at(mask, 0.05, 2.25), MapImage::kFree);
  EXPECT_EQ(std::count(mask.cells.begin(), mask.cells.end(), MapImage::kUnknown), 0);
}

TEST(EditExport, GeoJsonHasAFeatureForEachEditInEffect) {
  test::ChangingMap changing(5);
  EditCommand room = test::squareEdit(EditKind::kRoom, 1.0, 0.5);
  std::reverse(room.request.points.begin(), room.request.points.end());  // clockwise
  ASSERT_EQ(test::edit(changing.map, room), "");
  EditCommand dock = test::squareEdit(EditKind::kPlace, 0.5, 0.25);
  dock.request.points.resize(1);
  dock.request.name = "dock";
  ASSERT_EQ(test::edit(changing.map, dock), "");
  ASSERT_EQ(test::edit(changing.map, test::squareEdit(EditKind::kFree, 1.0, 0.5)), "");
  ASSERT_EQ(test::edit(changing.map, {.kind = EditCommand::kUndo, .request = {}, .id = 0, .utime = 0}), "");
  const auto all = nlohmann::json::parse(editsGeoJson(changing.map));
  EXPECT_EQ(all["type"], "FeatureCollection");
  ASSERT_EQ(all["features"].size(), 2U);
  const auto& ring = all["features"][0]["geometry"]["coordinates"][0];
  ASSERT_EQ(ring.size(), 5U);
  EXPECT_EQ(ring[0], ring[4]);
  double area = 0.0;
  for (std::size_t i = 0; i < 4; ++i)
    area += ring[i][0].get<double>() * ring[i + 1][1].get<double>() -
            ring[i + 1][0].get<double>() * ring[i][1].get<double>();
  EXPECT_NEAR(area, 2.0, 1e-6) << "counterclockwise";
  EXPECT_EQ(all["features"][1]["geometry"]["type"], "Point");
  EXPECT_EQ(all["features"][1]["properties"]["name"], "dock");
}

}  // namespace
}  // namespace slam::edit_export_test
