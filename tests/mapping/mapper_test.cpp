// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/mapper.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <memory>
#include <random>
#include <utility>
#include <vector>

namespace slam::mapper_test {
namespace {

/// Cells never come near their limits, so that the order of scans does not matter.
const OccupancyGridConfig kConfig{.resolution = 0.05,
                                  .lidar = {.min_probability = 1e-4, .max_probability = 1.0 - 1e-4}};

/// Scans of random points, spread over many tiles.
class MapperTest : public testing::Test {
 protected:
  MapScan scan(const Pose2& T_map_base, int id) {
    std::uniform_real_distribution<float> metres(-3.0F, 3.0F);
    auto stored = std::make_shared<StoredScan>();
    stored->T_base_lidar = {0.1, -0.05, 0.3};
    for (int i = 0; i < 40; ++i) {
      const float x = metres(random), y = metres(random);
      stored->points.push_back({.x = x, .y = y});
    }
    return {id, T_map_base, stored};
  }
  Pose2 draw(double size) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const double x = size * unit(random), y = size * unit(random);
    return {x, y, unit(random)};
  }
  /// Adds keyframes all over a hall.
  void fill(Mapper& mapper, int count) {
    for (int i = 0; i < count; ++i) {
      const int id = static_cast<int>(scans.size());
      scans.push_back(scan(draw(10.0), id));
      mapper.add(scans.back());
    }
  }
  /// Moves every third keyframe. @return the poses of all
  std::vector<Pose2> disturbed() {
    std::vector<Pose2> poses;
    for (MapScan& s : scans) {
      if (s.id % 3 == 0) s.T_map_base = s.T_map_base * draw(0.5);
      poses.push_back(s.T_map_base);
    }
    return poses;
  }
  OccupancyGrid drawnFresh() const {
    OccupancyGrid grid(kConfig);
    for (const MapScan& s : scans) grid.add(s.T_map_base, s.scan->T_base_lidar, s.scan->points);
    return grid;
  }

  std::mt19937 random{1};
  std::vector<MapScan> scans;  // keyframes as they should be drawn, by id
};

/// Cells whose values differ.
std::vector<CellIndex> differences(const OccupancyGrid& a, const OccupancyGrid& b) {
  std::vector<CellIndex> cells;
  const auto compare = [&](const OccupancyGrid& one, const OccupancyGrid& other) {
    one.tiles().forEachTile([&](TileIndex tile, const OccupancyGrid::Tiles::Tile&) {
      for (int row = 0; row < OccupancyGrid::kTileSide; ++row) {
        for (int column = 0; column < OccupancyGrid::kTileSide; ++column) {
          const CellIndex cell{tile.column * OccupancyGrid::kTileSide + column,
                               tile.row * OccupancyGrid::kTileSide + row};
          if (one.logOdds(cell) != other.logOdds(cell)) cells.push_back(cell);
        }
      }
    });
  };
  compare(a, b);
  compare(b, a);
  return cells;
}

/// @return calls of work() that it took
int finish(Mapper& mapper, int portion) {
  int calls = 1;
  while (mapper.work(portion) && calls < 10000) ++calls;
  return calls;
}

TEST_F(MapperTest, DrawsKeyframesWhereTheyAre) {
  Mapper mapper(kConfig);
  fill(mapper, 20);
  EXPECT_EQ(mapper.keyframes(), 20);
  EXPECT_TRUE(differences(mapper.grid(), drawnFresh()).empty());
  EXPECT_FALSE(mapper.work(100)) << "nothing has moved";
}

TEST_F(MapperTest, DrawsAMovedMapAsIfItHadBeenThereFromTheBeginning) {
  for (const int portion : {1, 2, 7, 1000}) {
    scans.clear();
    Mapper mapper(kConfig);
    fill(mapper, 30);
    const auto before = drawnFresh();
    mapper.move(disturbed());
    ASSERT_GT(differences(before, drawnFresh()).size(), 1000U);
    const int calls = finish(mapper, portion);
    EXPECT_TRUE(differences(mapper.grid(), drawnFresh()).empty()) << portion;
    EXPECT_LE(calls, (10 + 30) / portion + 2) << "scans examined and drawn, " << portion;
    EXPECT_FALSE(mapper.work(portion)) << "it is done";
  }
}

TEST_F(MapperTest, ShowsNothingHalfDone) {
  Mapper mapper(kConfig);
  fill(mapper, 30);
  const OccupancyGrid before = drawnFresh();
  mapper.takeChangedTiles();
  mapper.move(disturbed());
  for (int call = 0; mapper.work(3); ++call) {
    ASSERT_LT(call, 100);
    ASSERT_TRUE(differences(mapper.grid(), before).empty()) << call;
    ASSERT_TRUE(mapper.takeChangedTiles().empty()) << call;
  }
  const auto changed = mapper.takeChangedTiles();
  for (const CellIndex& cell : differences(mapper.grid(), before)) {
    ASSERT_NE(std::find(changed.begin(), changed.end(), OccupancyGrid::Tiles::tileOf(cell)), changed.end());
  }
}

TEST_F(MapperTest, TakesKeyframesWhileItDrawsAnew) {
  for (int calls = 0; calls < 40; ++calls) {
    scans.clear();
    Mapper mapper(kConfig);
    fill(mapper, 20);
    mapper.move(disturbed());
    for (int i = 0; i < calls; ++i) mapper.work(1);
    fill(mapper, 3);
    finish(mapper, 1);
    ASSERT_TRUE(differences(mapper.grid(), drawnFresh()).empty()) << "added after " << calls;
  }
}

TEST_F(MapperTest, BeginsAnewWhenTheMapMovesAgain) {
  for (const int calls : {0, 1, 5, 12, 25}) {
    scans.clear();
    Mapper mapper(kConfig);
    fill(mapper, 20);
    mapper.move(disturbed());
    for (int i = 0; i < calls; ++i) mapper.work(1);
    fill(mapper, 3);
    mapper.move(disturbed());
    finish(mapper, 2);
    EXPECT_TRUE(differences(mapper.grid(), drawnFresh()).empty()) << "moved again after " << calls;
  }
}

TEST_F(MapperTest, MovesThereAndBack) {
  Mapper mapper(kConfig);
  fill(mapper, 20);
  const OccupancyGrid before = drawnFresh();
  std::vector<Pose2> poses;
  for (const MapScan& s : scans) poses.push_back(s.T_map_base);
  mapper.move(disturbed());
  finish(mapper, 7);
  mapper.move(poses);
  finish(mapper, 7);
  EXPECT_TRUE(differences(mapper.grid(), before).empty());
}

TEST_F(MapperTest, KeyframesWithoutANewPoseStay) {
  Mapper mapper(kConfig);
  fill(mapper, 10);
  std::vector<Pose2> known;
  for (int i = 0; i < 6; ++i) known.push_back(scans[static_cast<std::size_t>(i)].T_map_base = draw(10.0));
  mapper.move(known);
  finish(mapper, 4);
  EXPECT_TRUE(differences(mapper.grid(), drawnFresh()).empty());
  known.resize(15);  // more than there are
  for (std::size_t i = 0; i < 10; ++i) known[i] = scans[i].T_map_base;
  mapper.move(known);
  finish(mapper, 4);
  EXPECT_TRUE(differences(mapper.grid(), drawnFresh()).empty());
}

TEST_F(MapperTest, SmallMovesCountOnceTheyAddUp) {
  Mapper mapper(kConfig);
  fill(mapper, 5);
  const OccupancyGrid before = drawnFresh();
  std::vector<Pose2> poses;
  for (const MapScan& s : scans) poses.push_back(s.T_map_base);
  const auto shift = [&](double metres) {
    for (Pose2& pose : poses) pose.x += metres;
    mapper.move(poses);
    finish(mapper, 10);
  };
  shift(0.009);  // a fifth of a cell is 10 mm
  EXPECT_TRUE(differences(mapper.grid(), before).empty());
  EXPECT_DOUBLE_EQ(mapper.path()[3].x(), poses[3].x);
  shift(0.009);
  for (std::size_t i = 0; i < scans.size(); ++i) scans[i].T_map_base = poses[i];
  EXPECT_TRUE(differences(mapper.grid(), drawnFresh()).empty());
}

TEST_F(MapperTest, DrawsAnewAKeyframeThatOnlyTurned) {
  for (const double turn : {0.4, -0.4, 0.003}) {  // the last is 15 mm at the ranges of a room
    scans.clear();
    Mapper mapper(kConfig);
    fill(mapper, 4);
    const OccupancyGrid before = drawnFresh();
    std::vector<Pose2> poses;
    scans[2].T_map_base.theta = wrapAngle(scans[2].T_map_base.theta + turn);
    for (const MapScan& s : scans) poses.push_back(s.T_map_base);
    mapper.move(poses);
    finish(mapper, 10);
    EXPECT_TRUE(differences(mapper.grid(), drawnFresh()).empty()) << turn;
    EXPECT_FALSE(differences(mapper.grid(), before).empty()) << turn;
  }
}

TEST_F(MapperTest, LeavesAKeyframeThatTurnedByLessThanShows) {
  Mapper mapper(kConfig);
  fill(mapper, 4);
  const OccupancyGrid before = drawnFresh();
  std::vector<Pose2> poses;
  for (const MapScan& s : scans) poses.push_back({s.T_map_base.x, s.T_map_base.y, s.T_map_base.theta + 0.0018});
  mapper.move(poses);
  finish(mapper, 10);
  EXPECT_TRUE(differences(mapper.grid(), before).empty());
}

TEST_F(MapperTest, ALookIsDrawnButNeverMoved) {
  Mapper mapper(kConfig);
  fill(mapper, 10);
  const MapScan look = scan({40.0, 0.0, 0.0}, -1);  // far from all else
  mapper.add(look);
  const auto expected = [&] {
    OccupancyGrid grid = drawnFresh();
    grid.add(look.T_map_base, look.scan->T_base_lidar, look.scan->points);
    return grid;
  };
  EXPECT_EQ(mapper.keyframes(), 10);
  EXPECT_EQ(mapper.path().size(), 10U);
  EXPECT_TRUE(differences(mapper.grid(), expected()).empty());
  mapper.move(disturbed());
  finish(mapper, 5);
  EXPECT_TRUE(differences(mapper.grid(), expected()).empty());
}

TEST_F(MapperTest, ALookDuringTheRedrawIsNotLost) {
  Mapper mapper(kConfig);
  fill(mapper, 10);
  mapper.move(disturbed());
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(mapper.work(1));  // the patch is begun
  const MapScan look = scan({0.0, 0.0, 0.0}, -1);
  mapper.add(look);
  finish(mapper, 1);
  OccupancyGrid expected = drawnFresh();
  expected.add(look.T_map_base, look.scan->T_base_lidar, look.scan->points);
  EXPECT_TRUE(differences(mapper.grid(), expected).empty());
}

TEST_F(MapperTest, ForgetsTheFirstKeyframesAsIfTheyHadNeverBeen) {
  Mapper mapper(kConfig);
  fill(mapper, 30);
  mapper.move(disturbed());  // not drawn yet
  mapper.forgetBefore(10);
  scans.erase(scans.begin(), scans.begin() + 10);
  EXPECT_TRUE(differences(mapper.grid(), drawnFresh()).empty());
  EXPECT_EQ(mapper.keyframes(), 20);
  EXPECT_EQ(mapper.path().size(), 20U);
  EXPECT_FALSE(mapper.work(1)) << "something is left to draw";
}

TEST_F(MapperTest, ResetForgetsAllOfIt) {
  Mapper mapper(kConfig);
  fill(mapper, 10);
  mapper.move(disturbed());
  mapper.work(2);
  mapper.reset();
  EXPECT_EQ(mapper.keyframes(), 0);
  EXPECT_EQ(mapper.grid().tiles().tileCount(), 0);
  EXPECT_TRUE(mapper.path().empty());
  EXPECT_FALSE(mapper.work(10));
  scans.clear();
  fill(mapper, 5);
  EXPECT_TRUE(differences(mapper.grid(), drawnFresh()).empty());
}

TEST_F(MapperTest, GivesThePathAtTheNewPoses) {
  Mapper mapper(kConfig);
  fill(mapper, 5);
  mapper.move(disturbed());
  const auto path = mapper.path();
  ASSERT_EQ(path.size(), 5U);
  for (std::size_t i = 0; i < path.size(); ++i) EXPECT_EQ(path[i], scans[i].T_map_base.translation());
}

TEST_F(MapperTest, GoesOnInALoadedMapAtItsResolution) {
  OccupancyGridConfig coarse = kConfig;
  coarse.resolution = 0.2;
  Mapper mapper(coarse);
  fill(mapper, 20);
  OccupancyGrid stored = mapper.grid().clone();
  fill(mapper, 3);  // not in the stored grid
  Mapper next(kConfig);
  next.load(scans, {}, std::move(stored), 20);
  EXPECT_EQ(next.keyframes(), 23);
  EXPECT_TRUE(differences(next.grid(), mapper.grid()).empty()) << "those that the stored grid lacks are drawn";
  const std::vector<Pose2> poses = disturbed();
  next.move(poses);
  next.work(1 << 20);
  mapper.move(poses);
  mapper.work(1 << 20);
  EXPECT_EQ(next.grid().resolution(), 0.2);
  EXPECT_TRUE(differences(next.grid(), mapper.grid()).empty());
  next.reset();
  EXPECT_EQ(next.grid().resolution(), kConfig.resolution);
}

/// A view with one obstacle 2 m ahead of the camera.
std::shared_ptr<const DepthView> obstacleAhead(Timestamp stamp) {
  auto view = std::make_shared<DepthView>();
  view->stamp = stamp;
  view->beams.push_back({0.0F, 2.0F, 1.0F, true});
  return view;
}

TEST_F(MapperTest, ADepthViewMovesWithItsKeyframe) {
  Mapper mapper(kConfig);
  fill(mapper, 3);
  mapper.add(MapView{1, scans[1].T_map_base, {0.1, 0.0, 0.2}, obstacleAhead(Timestamp{})});
  scans[1].T_map_base = scans[1].T_map_base * Pose2{0.5, 0.3, 0.4};
  std::vector<Pose2> poses;
  for (const MapScan& s : scans) poses.push_back(s.T_map_base);
  mapper.move(poses);
  finish(mapper, 2);
  OccupancyGrid expected = drawnFresh();
  expected.add(scans[1].T_map_base * Pose2{0.1, 0.0, 0.2}, *obstacleAhead(Timestamp{}));
  EXPECT_TRUE(differences(mapper.grid(), expected).empty());
}

TEST_F(MapperTest, KeepsAViewThatComesWhileItDrawsAnew) {
  for (const int calls : {0, 1, 5, 12, 25}) {
    for (const bool again : {false, true}) {
      scans.clear();
      Mapper mapper(kConfig);
      fill(mapper, 20);
      mapper.move(disturbed());
      for (int i = 0; i < calls; ++i) mapper.work(1);
      const Pose2 T_keyframe_base{0.1, 0.0, 0.2};
      mapper.add(MapView{3, scans[3].T_map_base, T_keyframe_base, obstacleAhead(Timestamp{})});
      if (again) mapper.move(disturbed());
      finish(mapper, 1);
      OccupancyGrid expected = drawnFresh();
      expected.add(scans[3].T_map_base * T_keyframe_base, *obstacleAhead(Timestamp{}));
      EXPECT_TRUE(differences(mapper.grid(), expected).empty()) << calls << ' ' << again;
      ASSERT_EQ(mapper.views().size(), 1U) << calls << ' ' << again;
      EXPECT_EQ(mapper.views().front().T_map_keyframe, scans[3].T_map_base);
    }
  }
}

TEST_F(MapperTest, ForgetsTheViewsOfKeyframesToo) {
  Mapper mapper(kConfig);
  fill(mapper, 2);
  const auto view = [&](int keyframe, std::int64_t s) {
    return MapView{keyframe,
                   scans[static_cast<std::size_t>(keyframe)].T_map_base,
                   {0.1, 0.0, 0.2},
                   obstacleAhead(Timestamp{std::chrono::seconds(s)})};
  };
  mapper.add(view(0, 1));
  mapper.add(view(1, 2));
  mapper.forgetBefore(1);
  ASSERT_EQ(mapper.views().size(), 1U);
  EXPECT_EQ(mapper.views().front().keyframe, 1);
  OccupancyGrid expected(kConfig);
  expected.add(scans[1].T_map_base, scans[1].scan->T_base_lidar, scans[1].scan->points);
  expected.add(mapper.views().front().T_map_base(), *mapper.views().front().view);
  EXPECT_TRUE(differences(mapper.grid(), expected).empty());
  mapper.add(view(1, 3));
  EXPECT_EQ(mapper.views().size(), 1U) << "it takes the place of the one before";
}

TEST_F(MapperTest, KeepsAFewViewsOfAKeyframeHoweverManyItDraws) {
  Mapper mapper(kConfig);
  fill(mapper, 2);
  for (int i = 0; i < 1000; ++i) {
    const Pose2 from{0.01 * (i % 7), 0.0, 1.5 * std::sin(0.1 * i)};
    mapper.add(MapView{i % 2, scans[0].T_map_base, from, obstacleAhead(Timestamp{std::chrono::milliseconds(100 * i)})});
  }
  const auto views = mapper.views();
  EXPECT_LE(views.size(), 2 * ViewMemoryConfig{}.per_keyframe);
  EXPECT_GE(views.size(), 4U);
  for (const MapView& view : views) {
    EXPECT_GT(view.view->stamp, Timestamp{std::chrono::seconds(80)}) << "the newest stay";
  }
}

TEST_F(MapperTest, GivesUpTheOldestOfTooManyViews) {
  Mapper mapper(kConfig);
  fill(mapper, 1);
  for (const int second : {3, 1, 4, 2, 5}) {  // three have room; 1 goes first, then 2
    const Pose2 from{0.5 * second, 0.0, 0.0};
    mapper.add(MapView{0, scans[0].T_map_base, from, obstacleAhead(Timestamp{std::chrono::seconds(second)})});
  }
  std::vector<std::int64_t> kept;
  for (const MapView& view : mapper.views())
    kept.push_back(std::lround(toSeconds(view.view->stamp.time_since_epoch())));
  std::sort(kept.begin(), kept.end());
  EXPECT_EQ(kept, (std::vector<std::int64_t>{3, 4, 5}));
}

TEST_F(MapperTest, RedrawsWhatMovedOrOnlyTurnedByMoreThanAFifthOfACell) {
  // A cell is 5 cm; a turn is taken for a motion at 5 m.
  const std::vector<std::pair<Pose2, bool>> motions{
      {{0.009, 0, 0}, false},  {{0.011, 0, 0}, true},     {{0, -0.009, 0}, false},
      {{0, -0.011, 0}, true},  {{0, 0, 0.0019}, false},   {{0, 0, 0.0021}, true},
      {{0, 0, -0.0021}, true}, {{0.006, 0, 0.001}, true}, {{0.004, 0, 0.001}, false}};
  for (const auto& [motion, redrawn] : motions) {
    scans.clear();
    Mapper mapper(kConfig);
    fill(mapper, 6);
    std::vector<Pose2> poses;
    for (MapScan& s : scans) poses.push_back(s.id == 2 ? s.T_map_base * motion : s.T_map_base);
    const OccupancyGrid before = drawnFresh();
    scans[2].T_map_base = poses[2];
    mapper.move(poses);
    finish(mapper, 100);
    EXPECT_EQ(differences(mapper.grid(), before).empty(), !redrawn)
        << motion.x << " " << motion.y << " " << motion.theta;
    if (redrawn) {
      EXPECT_TRUE(differences(mapper.grid(), drawnFresh()).empty());
    }
  }
}

TEST_F(MapperTest, AKeyframeThatLostPointsIsDrawnAnew) {
  for (int calls = 0; calls < 40; calls += 3) {  // in the middle of drawing, too
    scans.clear();
    Mapper mapper(kConfig);
    fill(mapper, 20);
    mapper.move(disturbed());
    for (int i = 0; i < calls; ++i) mapper.work(1);
    for (const std::size_t id : {7U, 8U}) {
      auto rest = std::make_shared<StoredScan>(*scans[id].scan);
      rest->points.resize(rest->points.size() / 2);
      scans[id].scan = rest;
      mapper.add(scans[id]);
    }
    fill(mapper, 1);
    finish(mapper, 1);
    EXPECT_EQ(mapper.keyframes(), 21);
    ASSERT_TRUE(differences(mapper.grid(), drawnFresh()).empty()) << calls;
    EXPECT_FALSE(mapper.work(1)) << "it is done";
  }
}

}  // namespace
}  // namespace slam::mapper_test
