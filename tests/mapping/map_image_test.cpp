// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/map_image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <stdexcept>

namespace slam {
namespace {

/// Looks from the middle of one cell at that of another, `times` times.
void look(OccupancyGrid& grid, CellIndex from, CellIndex to, int times) {
  const double side = grid.resolution();
  const auto scan = std::make_unique<Keyframe>();
  scan->T_map_base = {(from.column + 0.5) * side, (from.row + 0.5) * side, 0.0};
  scan->storage[0] = {static_cast<float>((to.column - from.column) * side + 1e-3),
                      static_cast<float>((to.row - from.row) * side)};
  scan->size = 1;
  for (int i = 0; i < times; ++i) grid.add(*scan);
}

TEST(Classify, HasOpenThresholds) {
  EXPECT_EQ(classify(0.0), MapImage::kFree);
  EXPECT_EQ(classify(0.1959), MapImage::kFree);
  EXPECT_EQ(classify(0.196), MapImage::kUnknown);
  EXPECT_EQ(classify(0.5), MapImage::kUnknown);
  EXPECT_EQ(classify(0.65), MapImage::kUnknown);
  EXPECT_EQ(classify(0.6501), MapImage::kOccupied);
  EXPECT_EQ(classify(1.0), MapImage::kOccupied);
}

TEST(Classify, TheThreeValuesLoadAsThemselvesInMapServer) {  // which takes p = (255 - value) / 255
  for (const std::uint8_t value : {MapImage::kOccupied, MapImage::kFree, MapImage::kUnknown})
    EXPECT_EQ(classify((255 - value) / 255.0), value);
}

TEST(RenderMap, CoversWhatIsKnownAndHasItsFirstRowAtTheTop) {
  OccupancyGrid grid({.resolution = 0.1, .lidar = {}});
  look(grid, {-3, -70}, {-3, 5}, 4);  // a free column below an occupied cell at the top
  look(grid, {2, -70}, {2, -71}, 4);  // and an occupied cell below right, seen from a free one
  const MapImage image = renderMap(grid);
  ASSERT_EQ(image.width, 6);
  ASSERT_EQ(image.height, 77);
  ASSERT_EQ(image.cells.size(), 6U * 77U);
  EXPECT_DOUBLE_EQ(image.resolution, 0.1);
  EXPECT_NEAR(image.origin_x, -0.3, 1e-9);
  EXPECT_NEAR(image.origin_y, -7.1, 1e-9);
  EXPECT_EQ(image.cells.front(), MapImage::kOccupied);
  EXPECT_EQ(image.cells.back(), MapImage::kOccupied);
  for (int row = 0; row < 77; ++row)
    for (int column = 0; column < 6; ++column)
      EXPECT_EQ(image.at(column, row), classify(toProbability(grid.logOdds({column - 3, row - 71}))));
}

TEST(RenderMap, RefusesAPictureOfPlacesThatLieTooFarApart) {
  OccupancyGrid grid({.resolution = 0.05, .lidar = {}});
  look(grid, {5, 5}, {9, 5}, 4);
  look(grid, {180'000, -5}, {180'009, -5}, 4);  // 9 km away, on a line with it: 2 million cells
  EXPECT_EQ(renderMap(grid).width, 180'005);
  look(grid, {5, 180'000}, {9, 180'000}, 4);
  EXPECT_EQ(grid.tiles().tileCount(), 3);
  try {
    renderMap(grid);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("x 180006 cells"));
    EXPECT_THAT(error.what(), testing::HasSubstr("the map itself stays as it is"));
  }
}

TEST(RenderMap, CellsSeenTooLittleToClassifyDoNotWidenIt) {
  OccupancyGrid grid({.resolution = 0.1, .lidar = {}});
  look(grid, {5, 5}, {9, 5}, 1);  // one miss each is not yet free, one hit is occupied
  const MapImage image = renderMap(grid);
  EXPECT_EQ(image.width, 1);
  EXPECT_EQ(image.height, 1);
  EXPECT_EQ(image.at(0, 0), MapImage::kOccupied);
  EXPECT_NEAR(image.origin_x, 0.9, 1e-9);
  EXPECT_NEAR(image.origin_y, 0.5, 1e-9);
}

TEST(RenderMap, OfAnEmptyGridIsOneUnknownCell) {
  const MapImage image = renderMap(OccupancyGrid({.resolution = 0.2, .lidar = {}}));
  EXPECT_EQ(image.width, 1);
  EXPECT_EQ(image.height, 1);
  EXPECT_EQ(image.cells, std::vector<std::uint8_t>{MapImage::kUnknown});
  EXPECT_DOUBLE_EQ(image.resolution, 0.2);
}

TEST(ToGrid, ShowsTheImageAgain) {
  OccupancyGrid grid({.resolution = 0.1, .lidar = {}});
  look(grid, {-3, -70}, {-3, 5}, 8);
  look(grid, {2, -70}, {100, -71}, 8);
  const MapImage image = renderMap(grid), again = renderMap(toGrid(image));
  EXPECT_EQ(again.width, image.width);
  EXPECT_EQ(again.cells, image.cells);
  EXPECT_DOUBLE_EQ(again.origin_x, image.origin_x);
  EXPECT_DOUBLE_EQ(again.origin_y, image.origin_y);
  EXPECT_EQ(again.resolution, image.resolution);
}

}  // namespace
}  // namespace slam
