// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/occupancy_grid.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <initializer_list>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "mapping/map_image.hpp"

namespace slam::occupancy_grid_test {
namespace {

const OccupancyGridConfig kConfig{.resolution = 0.1, .lidar = {}};
const LogOdds kHit = toLogOdds(kConfig.lidar.hit_probability);
const LogOdds kMiss = toLogOdds(kConfig.lidar.miss_probability);

/// A keyframe of a lidar that sits on the base's origin.
std::unique_ptr<Keyframe> keyframe(const Pose2& T_map_base, std::initializer_list<Keyframe::Point> points) {
  auto result = std::make_unique<Keyframe>();
  result->T_map_base = T_map_base;
  for (const auto& point : points) result->storage[static_cast<std::size_t>(result->size++)] = point;
  return result;
}

const Pose2 kInCellZero{0.05, 0.05, 0};

TEST(OccupancyGrid, MakesTheEndOfABeamOccupiedAndItsWayFree) {
  OccupancyGrid grid(kConfig);
  grid.add(*keyframe(kInCellZero, {{1.0F, 0.0F}}));
  for (int column = 0; column < 10; ++column) EXPECT_EQ(grid.logOdds({column, 0}), kMiss) << column;
  EXPECT_EQ(grid.logOdds({10, 0}), kHit);
  EXPECT_EQ(grid.logOdds({11, 0}), 0);
  EXPECT_EQ(grid.logOdds({5, 1}), 0);
  EXPECT_EQ(grid.logOdds({-1, 0}), 0);
}

TEST(OccupancyGrid, AGrazingBeamDoesNotEraseTheWallOfItsNeighbour) {
  const Keyframe::Point hit{1.0F, 0.0F}, grazing{2.0F, 0.0F};
  for (const auto& scan : {keyframe(kInCellZero, {hit, grazing}), keyframe(kInCellZero, {grazing, hit})}) {
    OccupancyGrid grid(kConfig);
    grid.add(*scan);
    EXPECT_EQ(grid.logOdds({10, 0}), kHit);
    EXPECT_EQ(grid.logOdds({20, 0}), kHit);
    EXPECT_EQ(grid.logOdds({15, 0}), kMiss);
  }
}

TEST(OccupancyGrid, EachCellChangesOnceAScan) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> metres(-3.0F, 3.0F);
  OccupancyGrid grid(kConfig);
  for (int i = 0; i < 30; ++i) {
    const OccupancyGrid::Tiles* tiles = &grid.tiles();
    std::vector<std::pair<CellIndex, LogOdds>> before;
    for (int row = -40; row < 40; ++row)
      for (int column = -40; column < 40; ++column) before.push_back({{column, row}, tiles->read({column, row}).lidar});
    const auto scan = keyframe(kInCellZero, {});
    for (scan->size = 0; scan->size < 500; ++scan->size)
      scan->storage[static_cast<std::size_t>(scan->size)] = {metres(random), metres(random)};
    grid.add(*scan);
    const LogOdds max = toLogOdds(kConfig.lidar.max_probability), min = toLogOdds(kConfig.lidar.min_probability);
    for (const auto& [cell, value] : before) {
      const int now = grid.logOdds(cell);
      ASSERT_TRUE(now == value || now == std::min<int>(value + kHit, max) || now == std::max<int>(value + kMiss, min));
    }
  }
}

TEST(OccupancyGrid, EachScanCountsHoweverManyThereWere) {
  OccupancyGrid grid(kConfig);
  constexpr int kSide = 256, kScans = kSide * kSide;  // beyond the range of any 16-bit serial
  const auto scan = keyframe({}, {{0.01F, 0.0F}});
  for (int i = 0; i < kScans + 10; ++i) {
    scan->T_map_base = {0.1 * (i % kSide) + 0.05, 0.1 * (i / kSide % kSide) + 0.05, 0.0};
    grid.add(*scan);
  }
  for (int i = 0; i < kScans; ++i)
    ASSERT_EQ(grid.logOdds({i % kSide, i / kSide}), i < 10 ? 2 * kHit : kHit) << "scan " << i;
}

TEST(OccupancyGrid, IsNeverTooSureToChangeItsMind) {
  OccupancyGrid grid(kConfig);
  const auto hit = keyframe(kInCellZero, {{1.0F, 0.0F}}), clear = keyframe(kInCellZero, {{2.0F, 0.0F}});
  for (int i = 0; i < 1000; ++i) grid.add(*hit);
  EXPECT_EQ(grid.logOdds({10, 0}), toLogOdds(kConfig.lidar.max_probability));
  EXPECT_EQ(grid.logOdds({5, 0}), toLogOdds(kConfig.lidar.min_probability));

  for (int i = 0; i < 8; ++i) grid.add(*clear);
  EXPECT_EQ(classify(toProbability(grid.logOdds({10, 0}))), MapImage::kFree);
}

TEST(OccupancyGrid, GrowsInAllDirectionsWithoutMovingCells) {
  OccupancyGrid grid(kConfig);
  for (const double heading : {0.0, 0.5, 1.0, 1.5}) {  // half turns: east, north, west, south, 20 m each
    const double angle = heading * std::numbers::pi;
    grid.add(*keyframe({0.05, 0.05, angle}, {{20.0F, 0.0F}}));
  }
  EXPECT_EQ(grid.logOdds({200, 0}), kHit);
  EXPECT_EQ(grid.logOdds({0, 200}), kHit);
  EXPECT_EQ(grid.logOdds({-200, 0}), kHit);
  EXPECT_EQ(grid.logOdds({0, -200}), kHit);
  EXPECT_EQ(grid.logOdds({-100, 0}), kMiss);
  EXPECT_EQ(grid.logOdds({0, 0}), 4 * kMiss);
}

TEST(OccupancyGrid, CellsOfNegativeCoordinatesAreAsLargeAsOthers) {
  const OccupancyGrid grid(kConfig);
  EXPECT_EQ(grid.cellAt({0.01, 0.09}), (CellIndex{0, 0}));
  EXPECT_EQ(grid.cellAt({-0.01, -0.09}), (CellIndex{-1, -1}));
  EXPECT_EQ(grid.cellAt({-0.11, 0.11}), (CellIndex{-2, 1}));
}

TEST(OccupancyGrid, BeamsBeginAtTheLidar) {
  OccupancyGrid grid(kConfig);
  const auto scan = keyframe({1.05, 1.05, std::numbers::pi / 2}, {{1.0F, 0.0F}});  // base looks north
  scan->T_base_lidar = {0.5, 0.0, 1.0};  // its heading does not matter: points are in base
  grid.add(*scan);
  EXPECT_EQ(grid.logOdds({10, 20}), kHit);
  EXPECT_EQ(grid.logOdds({10, 15}), kMiss);
  EXPECT_EQ(grid.logOdds({10, 14}), 0);
}

TEST(OccupancyGrid, DrawsNothingOfReturnsBeyondTheMaximumRange) {
  OccupancyGrid grid({.resolution = 0.1, .max_range = 2.0, .lidar = {}});
  grid.add(*keyframe(kInCellZero, {{2.1F, 0.0F}}));
  EXPECT_EQ(grid.tiles().tileCount(), 0);
  EXPECT_TRUE(grid.takeChangedTiles().empty());
  grid.add(*keyframe(kInCellZero, {{1.9F, 0.0F}}));
  EXPECT_EQ(grid.logOdds({19, 0}), kHit);
}

TEST(OccupancyGrid, ListsEachChangedTileOnceInOrderOfChange) {
  OccupancyGrid grid(kConfig);
  const Keyframe::Point here{0.01F, 0.0F};
  const double tile = 0.1 * OccupancyGrid::kTileSide;
  for (const Pose2& pose : {Pose2{3 * tile + 1, 1, 0}, {-0.5 * tile, 1, 0}, {3 * tile + 1, 1, 0}, {1, -1.5 * tile, 0}})
    grid.add(*keyframe(pose, {here}));
  EXPECT_EQ(grid.takeChangedTiles(), (std::vector<TileIndex>{{3, 0}, {-1, 0}, {0, -2}}));
  EXPECT_TRUE(grid.takeChangedTiles().empty());

  grid.add(*keyframe({-0.5 * tile, 1, 0}, {here}));
  EXPECT_EQ(grid.takeChangedTiles(), (std::vector<TileIndex>{{-1, 0}}));
}

TEST(OccupancyGrid, LogOddsAndProbabilityAreInverse) {
  for (double p = 0.03; p < 0.98; p += 0.01) EXPECT_NEAR(toProbability(toLogOdds(p)), p, 2e-4);
  EXPECT_EQ(toLogOdds(0.5), 0);
  EXPECT_EQ(toProbability(0), 0.5);
}

TEST(OccupancyGrid, ACopyIsIndependentAndSetStaysWithinTheClamp) {
  OccupancyGrid grid(kConfig);
  grid.set({-5, 70}, 32000);
  grid.set({6, -70}, -32000);
  EXPECT_EQ(grid.logOdds({-5, 70}), toLogOdds(kConfig.lidar.max_probability));
  EXPECT_EQ(grid.logOdds({6, -70}), toLogOdds(kConfig.lidar.min_probability));
  OccupancyGrid copy = grid.clone();
  EXPECT_EQ(copy.tiles().tileCount(), 2);
  EXPECT_EQ(copy.logOdds({-5, 70}), grid.logOdds({-5, 70}));
  copy.set({-5, 70}, 1);
  copy.set({500, 500}, 1);
  EXPECT_EQ(grid.logOdds({-5, 70}), toLogOdds(kConfig.lidar.max_probability));
  EXPECT_EQ(grid.tiles().tileCount(), 2);
}

/// A camera at the origin that sees one beam straight ahead.
DepthView viewOf(std::vector<DepthView::Beam> beams, std::vector<DepthView::Surface> surfaces = {}) {
  DepthView view;
  view.beams = std::move(beams);
  view.surfaces = std::move(surfaces);
  return view;
}

TEST(OccupancyGrid, ADepthViewIsFreeFromWhereAllHeightsAreSeenToItsHit) {
  OccupancyGrid grid(kConfig);
  grid.add(kInCellZero, viewOf({{0.0F, 2.0F, 1.0F, true}}, {{0.0F, 2.5F, 2.8F}}));
  for (int column = 0; column < 10; ++column) EXPECT_EQ(grid.logOdds({column, 0}), 0) << column;
  for (int column = 10; column < 20; ++column) EXPECT_LT(grid.logOdds({column, 0}), 0) << column;
  EXPECT_GT(grid.logOdds({20, 0}), 0);
  EXPECT_EQ(grid.logOdds({22, 0}), 0) << "between the obstacles nothing is known";
  for (int column = 25; column <= 28; ++column) EXPECT_GT(grid.logOdds({column, 0}), 0) << column;
  EXPECT_EQ(grid.logOdds({30, 0}), 0);
}

TEST(OccupancyGrid, ATableTopStaysHoweverOftenTheLidarLooksUnderIt) {
  OccupancyGrid grid(kConfig);
  grid.add(kInCellZero, viewOf({{0.0F, 2.0F, 1.0F, true}}));
  for (int i = 0; i < 50; ++i) grid.add(*keyframe(kInCellZero, {{4.0F, 0.0F}}));
  EXPECT_EQ(classify(toProbability(grid.logOdds({20, 0}))), MapImage::kOccupied);
  EXPECT_EQ(classify(toProbability(grid.logOdds({15, 0}))), MapImage::kFree);
}

TEST(OccupancyGrid, AFalseHitOfTheCameraFadesWhenItIsLookedThroughButNotInThePapersFusion) {
  for (const Fusion fusion : {Fusion::kLayers, Fusion::kPaper}) {
    OccupancyGridConfig config = kConfig;
    config.fusion = fusion;
    OccupancyGrid grid(config);
    grid.add(kInCellZero, viewOf({{0.0F, 2.0F, 1.0F, true}}));
    for (int i = 0; i < 5; ++i) grid.add(kInCellZero, viewOf({{0.0F, 3.0F, 1.0F, false}}));
    const auto expected = fusion == Fusion::kLayers ? MapImage::kFree : MapImage::kOccupied;
    EXPECT_EQ(classify(toProbability(grid.logOdds({20, 0}))), expected) << static_cast<int>(fusion);
  }
}

TEST(OccupancyGrid, ALookBehindAPatchCountsInItsCells) {
  OccupancyGrid grid(kConfig);
  const TileIndex tile{0, 0};
  OccupancyGrid patch = OccupancyGrid::patch(kConfig, {&tile, 1});
  const auto scan = keyframe(kInCellZero, {{1.0F, 0.0F}});
  patch.add(*scan);
  patch.add(*scan);
  grid.add(*keyframe({20.05, 20.05, 0}, {{1.0F, 0.0F}}));  // the next is the second look here, too
  grid.replaceBy(std::move(patch));
  grid.add(*scan);
  EXPECT_EQ(grid.logOdds({10, 0}), 3 * kHit);
}

TEST(OccupancyGrid, APatchBringsBothLayersAndWhatWasSeen) {
  OccupancyGrid grid(kConfig);
  const TileIndex tile{0, 0};
  OccupancyGrid patch = OccupancyGrid::patch(kConfig, {&tile, 1});
  patch.add(*keyframe(kInCellZero, {{1.0F, 0.0F}}));
  patch.add(kInCellZero, viewOf({{0.0F, 2.0F, 1.0F, true}}));
  grid.replaceBy(std::move(patch));
  EXPECT_GT(grid.logOdds({10, 0}), kMiss) << "lidar";
  EXPECT_GT(grid.logOdds({20, 0}), 0) << "depth";
  EXPECT_TRUE(grid.tiles().read({5, 0}).seen());
  EXPECT_FALSE(grid.tiles().read({5, 5}).seen());
}

}  // namespace
}  // namespace slam::occupancy_grid_test
