// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/tile_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/web/map_tiles.hpp"

namespace slam::tile_store_test {
namespace {

using test::gunzipped;
using test::noisyTile;
using test::tileAt;
using test::tilesIn;

std::vector<std::uint8_t> shades(const map_tile_t& tile) {
  std::vector<std::uint8_t> shades;
  for (const auto cell : tile.cells) shades.push_back(shadeOf(static_cast<std::uint8_t>(cell)));
  return shades;
}

TEST(TileStore, GivesEachTileAsItCame) {
  TileStore store;
  store.begin(7);
  const map_tile_t first = noisyTile(7, 3, -2, 1), second = noisyTile(7, -1, 0, 2);
  EXPECT_TRUE(store.put(MapLayer::kBoth, first));
  EXPECT_TRUE(store.put(MapLayer::kDepth, second));
  const auto tiles = tilesIn(store.changedSince(0));
  ASSERT_EQ(tiles.size(), 2U);
  EXPECT_EQ(tiles[0].layer, 0);
  EXPECT_EQ(tiles[0].column, 3);
  EXPECT_EQ(tiles[0].row, -2);
  EXPECT_EQ(tiles[0].cells, shades(first));
  EXPECT_EQ(tiles[1].layer, 2);
  EXPECT_EQ(tiles[1].cells, shades(second));
}

TEST(TileStore, KeepsShadesThatMapServerTakesForTheSame) {
  for (int percent = 0; percent <= 100; ++percent) {
    const std::uint8_t shade = shadeOf(static_cast<std::uint8_t>(percent));
    EXPECT_EQ(classify(shade / 100.0), classify(percent / 100.0)) << percent;
    EXPECT_EQ(shade > 50, percent >= 50) << percent;
  }
  EXPECT_EQ(shadeOf(255), 255);
  TileStore store;
  map_tile_t tile = tileAt(0, 0, 0);
  tile.cells[9] = 5;
  EXPECT_TRUE(store.put(MapLayer::kBoth, tile));
  tile.cells[9] = 7;
  EXPECT_FALSE(store.put(MapLayer::kBoth, tile)) << "nobody would see it";
}

TEST(TileStore, GivesOnlyWhatChangedSinceAVersion) {
  TileStore store;
  store.begin(7);
  store.put(MapLayer::kBoth, noisyTile(7, 0, 0, 1));
  store.put(MapLayer::kBoth, noisyTile(7, 1, 0, 2));
  const std::uint64_t before = store.version();
  EXPECT_FALSE(store.put(MapLayer::kBoth, noisyTile(7, 0, 0, 1))) << "a refresh changes nothing";
  EXPECT_EQ(store.version(), before);
  EXPECT_THAT(tilesIn(store.changedSince(before)), testing::IsEmpty());
  store.put(MapLayer::kBoth, noisyTile(7, 1, 0, 3));
  const auto tiles = tilesIn(store.changedSince(before));
  ASSERT_EQ(tiles.size(), 1U);
  EXPECT_EQ(tiles[0].column, 1);
  EXPECT_EQ(tilesIn(store.changedSince(store.version() + 1)).size(), 2U) << "a version of another run: all of it";
}

TEST(TileStore, HoldsMapResolutionAndVersion) {
  TileStore store;
  store.begin(-5);
  store.setResolution(0.1);
  const test::MapHead head = test::headIn(store.changedSince(0));
  EXPECT_EQ(head.magic, "SLMT");
  EXPECT_EQ(head.map_id, -5);
  EXPECT_EQ(head.resolution, 0.1);
  EXPECT_EQ(head.side, TileStore::kSide);
  EXPECT_EQ(head.version, static_cast<double>(store.version()));
}

TEST(TileStore, ForgetsAMapWhenAnotherBegins) {
  TileStore store;
  store.begin(7);
  store.put(MapLayer::kBoth, noisyTile(7, 0, 0, 1));
  const std::uint64_t before = store.version();
  store.begin(8);
  EXPECT_GT(store.version(), before);
  EXPECT_EQ(store.size(), 0U);
  EXPECT_EQ(store.bytes(), 0U);
  EXPECT_FALSE(store.put(MapLayer::kBoth, noisyTile(7, 0, 0, 1))) << "a tile of the map before";
  EXPECT_TRUE(store.put(MapLayer::kBoth, noisyTile(8, 0, 0, 1)));
}

TEST(TileStore, RefusesTilesThatNoMapHas) {
  TileStore store;
  EXPECT_FALSE(store.put(MapLayer::kBoth, noisyTile(0, TileStore::kFarthest + 1, 0, 1)));
  EXPECT_FALSE(store.put(MapLayer::kBoth, noisyTile(0, 0, std::numeric_limits<std::int32_t>::min(), 1)));
  map_tile_t other_side = tileAt(0, 0, 0);
  other_side.side = 32;
  other_side.ncells = 32 * 32;
  other_side.cells.resize(32 * 32);
  EXPECT_FALSE(store.put(MapLayer::kBoth, other_side));
  store.setResolution(std::nan(""));
  store.setResolution(-1.0);
  EXPECT_EQ(store.resolution(), OccupancyGridConfig{}.resolution);
  EXPECT_EQ(store.size(), 0U);
}

TEST(TileStore, KeepsItsMemoryBounded) {
  TileStore store;
  const int enough = static_cast<int>(TileStore::kMostTiles) + 100;
  map_tile_t tile = tileAt(0, 0, 0);
  for (int i = 0; i < enough; ++i) {
    tile.column = i % 1000, tile.row = i / 1000;
    store.put(MapLayer::kBoth, tile);
  }
  EXPECT_EQ(store.size(), TileStore::kMostTiles);
  EXPECT_LE(store.bytes(), TileStore::kMostBytes + 8192);
  tile.cells[0] = 90;
  tile.column = tile.row = 0;
  EXPECT_TRUE(store.put(MapLayer::kBoth, tile)) << "a tile that is known still changes";
}

TEST(TileStore, DrawsTheMapInTheValuesOfMapServer) {
  TileStore store;
  store.setResolution(0.1);
  map_tile_t left = tileAt(0, -1, 0), right = tileAt(0, 0, 1);
  left.cells[0] = 90;                                        // its lower left corner
  right.cells[TileStore::kSide * TileStore::kSide - 1] = 5;  // its upper right corner
  store.put(MapLayer::kBoth, left);
  store.put(MapLayer::kBoth, right);
  store.put(MapLayer::kDepth, noisyTile(0, 9, 9, 1));  // no part of the picture
  const auto image = store.image();
  ASSERT_TRUE(image);
  EXPECT_EQ(image->width, 2 * TileStore::kSide);
  EXPECT_EQ(image->height, 2 * TileStore::kSide);
  EXPECT_DOUBLE_EQ(image->origin_x, -6.4);
  EXPECT_DOUBLE_EQ(image->origin_y, 0.0);
  EXPECT_EQ(image->at(0, 0), MapImage::kOccupied);
  EXPECT_EQ(image->at(2 * TileStore::kSide - 1, 2 * TileStore::kSide - 1), MapImage::kFree);
  EXPECT_EQ(image->at(5, 5), MapImage::kUnknown);
}

TEST(TileStore, DrawsNoMapThatIsTooLarge) {
  TileStore store;
  EXPECT_EQ(store.image()->cells.size(), 1U) << "an empty map is one unknown cell";
  store.put(MapLayer::kBoth, tileAt(0, -TileStore::kFarthest, -TileStore::kFarthest));
  store.put(MapLayer::kBoth, tileAt(0, TileStore::kFarthest, TileStore::kFarthest));
  EXPECT_FALSE(store.image());
}

TEST(BlockDeflater, JoinsBlocksInAnyOrder) {
  BlockDeflater deflater;
  const std::vector<std::uint8_t> text{'a', 'b', 'c'}, none;
  EXPECT_EQ(deflater.compress(text).deflated, deflater.compress(text).deflated) << "nothing is left of the one before";
  EXPECT_EQ(deflater.compress(none).size, 0U);
}

}  // namespace
}  // namespace slam::tile_store_test
