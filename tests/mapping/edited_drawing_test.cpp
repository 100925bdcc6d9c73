// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/edited_drawing.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <random>

#include "mapping/mapper.hpp"

namespace slam::edited_drawing_test {
namespace {

const OccupancyGridConfig kConfig;  // 5 cm

/// A wall at x = 2 m, seen from a place on the x axis.
std::shared_ptr<const StoredScan> wall(double from_x) {
  auto scan = std::make_shared<StoredScan>();
  for (double y = -2.0; y < 2.0; y += 0.02)
    scan->points.push_back({.x = static_cast<float>(2.01 - from_x), .y = static_cast<float>(y)});
  return scan;
}

/// Cells of the wall that are drawn as occupied between two y [m].
int occupied(const OccupancyGrid& grid, double low, double high) {
  int count = 0;
  for (double y = low + 0.025; y < high; y += 0.05) count += grid.logOdds(grid.cellAt({2.01, y})) > 0 ? 1 : 0;
  return count;
}

Outline box(double x, double y, double width, double height) {
  return {{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}};
}

Mapper drawn(int scans) {
  Mapper mapper(kConfig);
  for (int id = 0; id < scans; ++id) mapper.add(MapScan{id, {0.1 * id, 0.0, 0.0}, wall(0.1 * id)});
  return mapper;
}

void finish(Mapper& mapper) { mapper.work(std::numeric_limits<int>::max()); }

TEST(EditedDrawing, NothingIsOccupiedWhereAnEditKeepsTheMapFree) {
  Mapper mapper = drawn(3);
  ASSERT_GT(occupied(mapper.grid(), -1.0, 1.0), 30);
  mapper.apply({.free = {box(1.9, -0.5, 0.2, 1.0)}, .erased = {}});
  finish(mapper);
  EXPECT_EQ(occupied(mapper.grid(), -0.5, 0.5), 0);
  EXPECT_GT(occupied(mapper.grid(), 0.6, 1.6), 15);
  mapper.add(MapScan{3, {0.0, 0.0, 0.0}, wall(0.0)});   // a keyframe
  mapper.add(MapScan{-1, {0.0, 0.0, 0.0}, wall(0.0)});  // a refresh
  EXPECT_EQ(occupied(mapper.grid(), -0.5, 0.5), 0);
  mapper.apply({});
  finish(mapper);
  EXPECT_GT(occupied(mapper.grid(), -0.5, 0.5), 15);
}

TEST(EditedDrawing, AThinOutlineCountsWhereItTouchesACell) {
  Mapper mapper = drawn(3);
  mapper.apply({.free = {box(2.004, -0.5, 0.001, 1.0)}, .erased = {}});
  finish(mapper);
  EXPECT_EQ(occupied(mapper.grid(), -0.5, 0.5), 0);
}

TEST(EditedDrawing, FreeZonesLastOverClosuresAndALoad) {
  Mapper mapper = drawn(3);
  const EditedDrawing edits{.free = {box(1.9, -0.5, 0.2, 1.0)}, .erased = {}};
  mapper.apply(edits);
  const Pose2 T_new_old{0.0, 0.5, 0.0};
  std::vector<Pose2> poses;
  for (int id = 0; id < 3; ++id) poses.push_back(T_new_old * Pose2{0.1 * id, 0.0, 0.0});
  mapper.move(poses);  // before the edit has been drawn
  mapper.apply({.free = {box(1.9, 0.0, 0.2, 1.0)}, .erased = {}});
  finish(mapper);
  EXPECT_EQ(occupied(mapper.grid(), 0.0, 1.0), 0);
  EXPECT_GT(occupied(mapper.grid(), -0.6, -0.05), 8);
  Mapper next(kConfig);
  std::vector<MapScan> scans;
  for (int id = 0; id < 4; ++id)
    scans.push_back({id, id < 3 ? poses[static_cast<std::size_t>(id)] : poses[0], wall(0.1 * (id % 3))});
  next.load(scans, {}, mapper.grid().clone(), 3, {.free = {box(1.9, 0.0, 0.2, 1.0)}, .erased = {}});
  EXPECT_EQ(occupied(next.grid(), 0.0, 1.0), 0);
}

TEST(EditedDrawing, WhatNoKeyframeShowsGoesWhereAnEditDrawsAnew) {
  Mapper mapper = drawn(2);
  auto chair = std::make_shared<StoredScan>();
  for (double y = 0.0; y < 0.3; y += 0.02) chair->points.push_back({.x = 1.01F, .y = static_cast<float>(y)});
  for (int i = 0; i < 5; ++i) mapper.add(MapScan{-1, {}, chair});
  const CellIndex seat = mapper.grid().cellAt({1.01, 0.11});
  ASSERT_GT(mapper.grid().logOdds(seat), 0);
  const std::vector<Outline> anew{box(0.9, 0.0, 0.2, 0.3)};
  mapper.apply({}, anew);
  finish(mapper);
  EXPECT_LE(mapper.grid().logOdds(seat), 0);
}

TEST(EditedDrawing, AScanThatLostPointsIsDrawnAnewAndTheGridIsThatOfAllScansAlone) {
  Mapper mapper = drawn(3);
  std::vector<std::shared_ptr<StoredScan>> rest;
  for (int id = 0; id < 3; ++id) {
    rest.push_back(std::make_shared<StoredScan>(*wall(0.1 * id)));
    std::erase_if(rest.back()->points, [](const Keyframe::Point& point) { return std::abs(point.y) < 0.5F; });
    mapper.add(MapScan{id, {0.1 * id, 0.0, 0.0}, rest.back()});
  }
  finish(mapper);
  OccupancyGrid expected(kConfig);
  for (int id = 0; id < 3; ++id) expected.add({0.1 * id, 0.0, 0.0}, {}, rest[static_cast<std::size_t>(id)]->points);
  EXPECT_EQ(occupied(mapper.grid(), -0.45, 0.45), 0);
  for (double x = 0.0; x < 2.2; x += 0.05) {
    for (double y = -2.0; y < 2.0; y += 0.05) {
      const CellIndex cell = expected.cellAt({x, y});
      EXPECT_EQ(mapper.grid().logOdds(cell), expected.logOdds(cell)) << x << " " << y;
    }
  }
}

TEST(EditedDrawing, AnEraseTakesPartsOfTheDepthViewsThatThereWere) {
  auto view = std::make_shared<DepthView>();
  view->beams = {{0.0F, 2.0F, 0.5F, true}, {0.5F, 2.0F, 0.5F, true}, {0.0F, 2.0F, 0.5F, false}};
  view->surfaces = {{0.0F, 2.0F, 2.5F}, {0.5F, 2.0F, 2.5F}};
  const MapView before{4, {}, {}, view, 2}, after{4, {}, {}, view, 3}, other{5, {}, {}, view, 2};
  const std::vector<EditedDrawing::Erased> erased{{3, box(1.5, -0.5, 1.5, 1.0), {{4, Pose2{}}}}};
  EXPECT_EQ(shownOf(before, erased)->beams.size(), 2U);  // what was seen through stays
  EXPECT_EQ(shownOf(before, erased)->surfaces.size(), 1U);
  EXPECT_EQ(shownOf(after, erased), view);
  EXPECT_EQ(shownOf(other, erased), view);
  Mapper mapper(kConfig);
  mapper.add(before);
  const CellIndex hit = mapper.grid().cellAt({2.01, 0.01});
  ASSERT_GT(mapper.grid().logOdds(hit), 0);
  mapper.apply({.free = {}, .erased = erased});
  finish(mapper);
  EXPECT_LE(mapper.grid().logOdds(hit), 0);
  ASSERT_EQ(mapper.views().size(), 1U);
  EXPECT_EQ(mapper.views()[0].view, view);  // whole, to be stored
  EXPECT_EQ(mapper.views()[0].edit, 2);
  mapper.apply({});
  finish(mapper);
  EXPECT_GT(mapper.grid().logOdds(hit), 0);
}

TEST(EditedDrawing, FindsTheTilesUnderAnOutline) {
  const Mapper mapper = drawn(1);
  EXPECT_EQ(tilesUnder(box(-100.0, -100.0, 200.0, 200.0), mapper.grid()).size(),
            static_cast<std::size_t>(mapper.grid().tiles().tileCount()));
  EXPECT_TRUE(tilesUnder(box(50.0, 50.0, 1.0, 1.0), mapper.grid()).empty());
}

}  // namespace
}  // namespace slam::edited_drawing_test
