// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/map_image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/pose2.hpp"

namespace slam::map_image_test {
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

/// An image of letters, the upper row first: # occupied, . free, blank unknown.
MapImage imageOf(const std::vector<std::string>& rows) {
  MapImage image{.width = static_cast<int>(rows[0].size()), .height = static_cast<int>(rows.size()), .cells = {}};
  image.origin_x = 1.0;
  image.origin_y = 2.0;
  for (const std::string& row : rows) {
    for (const char c : row)
      image.cells.push_back(c == '#' ? MapImage::kOccupied : c == '.' ? MapImage::kFree : MapImage::kUnknown);
  }
  return image;
}

TEST(AlongAxes, TurnsByQuartersWithoutLoss) {
  const MapImage image = imageOf({"#.", " .", "##"});
  for (const double rounding : {0.0, 5e-5, -5e-5}) {
    const MapImage left = alongAxes(image, std::numbers::pi / 2 + rounding);
    const MapImage expected = imageOf({"..#", "# #"});
    EXPECT_EQ(left.width, 3);
    EXPECT_EQ(left.cells, expected.cells);
    EXPECT_NEAR(left.origin_x, 1.0 - 3 * 0.05, 1e-4);  // the lower left corner is the lower right one now
    EXPECT_NEAR(left.origin_y, 2.0, 1e-4);
    const MapImage back = alongAxes(image, -std::numbers::pi + rounding);
    EXPECT_EQ(back.cells, imageOf({"##", ". ", ".#"}).cells);
    EXPECT_NEAR(back.origin_x, 0.9, 1e-4);
    EXPECT_NEAR(back.origin_y, 1.85, 1e-4);
  }
}

TEST(AlongAxes, KeepsEachOccupiedCellInItsPlaceAtAnyAngle) {
  std::mt19937 random(1);
  MapImage image = imageOf(std::vector<std::string>(30, std::string(50, '.')));
  for (std::uint8_t& cell : image.cells)
    if (random() % 10 == 0) cell = MapImage::kOccupied;
  for (double yaw = -6.3; yaw < 6.3; yaw += 0.37) {
    const MapImage turned = alongAxes(image, yaw);
    const Pose2 T_map_image{image.origin_x, image.origin_y, yaw};
    for (int row = 0; row < image.height; ++row) {
      for (int column = 0; column < image.width; ++column) {
        const Eigen::Vector2d p = T_map_image * Eigen::Vector2d((column + 0.5) * 0.05, (row + 0.5) * 0.05);
        const int x = static_cast<int>(std::floor((p.x() - turned.origin_x) / 0.05));
        const int y = static_cast<int>(std::floor((p.y() - turned.origin_y) / 0.05));
        ASSERT_TRUE(x >= 0 && y >= 0 && x < turned.width && y < turned.height);
        if (image.at(column, row) == MapImage::kOccupied) {
          ASSERT_EQ(turned.at(x, y), MapImage::kOccupied) << yaw;
        } else if (row > 0 && column > 0 && row < image.height - 1 && column < image.width - 1) {
          ASSERT_NE(turned.at(x, y), MapImage::kUnknown) << yaw << ": no hole in what is free";
        }
      }
    }
  }
}

TEST(AlongAxes, RefusesWhatBecomesTooLarge) {
  MapImage line{.width = 50'000, .height = 1, .cells = std::vector<std::uint8_t>(50'000, MapImage::kFree)};
  EXPECT_EQ(alongAxes(line, std::numbers::pi).cells, line.cells);
  EXPECT_THROW(alongAxes(line, 0.7), std::runtime_error);
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
}  // namespace slam::map_image_test
