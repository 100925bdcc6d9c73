// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/maps/map_pictures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mapping/map_image.hpp"
#include "store/map_store.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::map_pictures_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::StartsWith;
constexpr Timestamp kNow{Duration(100s)};

/// 1000 by 500 cells, free, with a wall of one cell along the upper edge.
OccupancyGrid wideGrid() {
  MapImage image;
  image.width = 1000, image.height = 500;
  image.cells.assign(500'000, MapImage::kFree);
  for (int column = 0; column < image.width; ++column) image.at(column, 499) = MapImage::kOccupied;
  return toGrid(image);
}

TEST(SmallPicture, KeepsThinWalls) {
  const ColourImage picture = smallPicture(wideGrid(), 100);
  EXPECT_EQ(picture.width, 100);
  EXPECT_EQ(picture.height, 50);
  for (int column = 0; column < picture.width; ++column) {
    EXPECT_LT(picture.at(column, 0).red, 80) << column;
    EXPECT_GT(picture.at(column, 25).red, 200) << column;
  }
}

TEST(SmallPicture, OfAnEmptyMapIsOnePixel) {
  const ColourImage picture = smallPicture(OccupancyGrid(OccupancyGridConfig{}), 100);
  EXPECT_EQ(picture.width * picture.height, 1);
}

TEST(MapPictures, HaveNamesInTheirPaths) {
  EXPECT_EQ(MapPictures::nameIn("/api/v1/maps/home.png"), "home");
  for (const char* path : {"/api/v1/maps", "/api/v1/maps/", "/api/v1/maps/.png", "/api/v1/maps/../x.png",
                           "/api/v1/maps/a/b.png", "/api/v1/maps/.hidden.png", "/maps/home.png", "/api/v1/maps/home"})
    EXPECT_FALSE(MapPictures::nameIn(path)) << path;
}

TEST(MapPictures, AreDrawnAnewOnceTheMapHasChanged) {
  const test::Folder folder;
  test::ChangingMap changing(4);
  MapStore(folder / "", "home").checkpoint(changing.map);
  const MapPictures pictures(folder / "", test::smallGrid());
  const std::string first = pictures.png("home", kNow);
  EXPECT_THAT(first, StartsWith("\x89PNG"));
  for (int i = 0; i < 9; ++i) changing.addKeyframe(true);
  changing.map.grid_keyframes = changing.map.keyframes.size();
  MapStore(folder / "", "home").checkpoint(changing.map);
  EXPECT_EQ(pictures.png("home", kNow + 1s), first) << "slamd may write it each second";
  EXPECT_NE(pictures.png("home", kNow + MapPictures::kAge), first);
}

TEST(MapPictures, AreOfMapsThatAreThere) {
  const test::Folder folder;
  std::filesystem::create_directories(folder / "broken/000001");
  folder.write("broken/000001/MANIFEST", "nothing");
  const MapPictures pictures(folder / "", test::smallGrid());
  EXPECT_THAT(test::refusalOf([&] { pictures.png("cellar", kNow); }), HasSubstr("no map \"cellar\""));
  EXPECT_NE(test::refusalOf([&] { pictures.png("broken", kNow); }), "");
}

}  // namespace
}  // namespace slam::map_pictures_test
