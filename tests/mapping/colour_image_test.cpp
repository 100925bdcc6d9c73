// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/colour_image.hpp"

#include <gtest/gtest.h>
#include <png.h>

namespace slam::colour_image_test {
namespace {

constexpr Rgb kBlack{0, 0, 0}, kWhite{254, 254, 254}, kGrey{205, 205, 205};

MapImage threeCells() {  // occupied above, free and unknown below
  MapImage map{.width = 2, .height = 2, .cells = {}};
  map.cells = {MapImage::kOccupied, MapImage::kUnknown, MapImage::kFree, MapImage::kUnknown};
  return map;
}

TEST(ColourMap, DrawsEachCellAsASquareOfPixelsWithTheTopRowFirst) {
  for (const int scale : {1, 3}) {
    const ColourImage image = colourMap(threeCells(), scale);
    ASSERT_EQ(image.width, 2 * scale);
    ASSERT_EQ(image.height, 2 * scale);
    for (int row = 0; row < image.height; ++row) {
      for (int column = 0; column < image.width; ++column) {
        const Rgb left = row < scale ? kBlack : kWhite;
        EXPECT_EQ(image.at(column, row), column < scale ? left : kGrey) << column << " " << row;
      }
    }
  }
}

TEST(ColourImage, TakesNoPixelOutsideItself) {
  ColourImage image = colourMap(threeCells());
  const auto before = image.pixels;
  for (const auto& [column, row] : {std::pair(-1, 0), {0, -1}, {2, 0}, {0, 2}}) image.set(column, row, kPathColour);
  EXPECT_EQ(image.pixels, before);
  image.set(1, 1, kPathColour);
  EXPECT_EQ(image.at(1, 1), kPathColour);
}

TEST(EncodePng, KeepsEveryPixelAndGivesTheSameBytesAgain) {
  ColourImage image = colourMap(threeCells(), 5);
  image.set(3, 7, {1, 2, 3});
  const std::string bytes = encodePng(image);
  EXPECT_EQ(encodePng(image), bytes);
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()));
  png.format = PNG_FORMAT_RGB;
  std::vector<Rgb> read(image.pixels.size());
  ASSERT_EQ(png.width * png.height, read.size());
  ASSERT_TRUE(png_image_finish_read(&png, nullptr, read.data(), 0, nullptr));
  EXPECT_EQ(read, image.pixels);
}

}  // namespace
}  // namespace slam::colour_image_test
