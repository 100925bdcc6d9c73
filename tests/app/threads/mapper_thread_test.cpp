// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/mapper_thread.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "support/wait_until.hpp"
#include "tools/files.hpp"

namespace slam::mapper_thread_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::waitUntil;
using testing::HasSubstr;

class MapFiles : public testing::Test {
 protected:
  std::string problemOf(const MapperThread& mapper) { return mapper.storage(monotonicNow()).problem.words(); }

  const test::Folder folder;
  Config config;
  WallClock clock;
  Channels channels;
};

TEST_F(MapFiles, AreWrittenWhereTheirFolderCanBeMade) {
  config.output.map = folder / "a/b/map";
  MapperThread mapper(config, channels.mapper(), clock);
  mapper.finish();
  EXPECT_TRUE(mapper.waitUntilSaved(monotonicNow() + 20s));
  EXPECT_TRUE(fs::exists(folder / "a/b/map.yaml"));
  EXPECT_EQ(problemOf(mapper), "");
}

TEST_F(MapFiles, AreReportedAsSoonAsTheirFolderIsOfNoUse) {
  folder.write("disk", "not mounted yet");
  config.output.map = folder / "disk/map";
  MapperThread mapper(config, channels.mapper(), clock);
  mapper.worker().start();
  ASSERT_TRUE(waitUntil([&] { return !problemOf(mapper).empty(); }));
  EXPECT_THAT(problemOf(mapper), testing::AllOf(HasSubstr("disk"), HasSubstr("output.map")));
  channels.requests.save = true;
  ASSERT_TRUE(waitUntil([&] { return channels.requests.saved == SaveOutcome::kFailed; }));
  fs::remove(folder / "disk");
  ASSERT_TRUE(waitUntil([&] { return problemOf(mapper).empty(); })) << problemOf(mapper);
  mapper.worker().stop();
  mapper.finish();
  EXPECT_TRUE(mapper.waitUntilSaved(monotonicNow() + 20s));
  EXPECT_TRUE(fs::exists(folder / "disk/map.png"));
}

TEST_F(MapFiles, OfPlacesTooFarApartAreRefusedAndTheThreadGoesOn) {
  config.output.map = folder / "map";
  MapperThread mapper(config, channels.mapper(), clock);
  auto change = std::make_shared<MapChange>();
  int id = 0;
  for (const Pose2& T_map_base : {Pose2{0.0, 0.0, 0.0}, {9000.0, 0.0, 0.0}, {0.0, 9000.0, 0.0}}) {
    auto scan = std::make_shared<StoredScan>();
    scan->points.push_back({2.0F, 0.0F});
    change->scans.push_back({id++, T_map_base, scan});
  }
  ASSERT_TRUE(channels.map.changes.tryPush(change));
  mapper.finish();
  EXPECT_FALSE(mapper.waitUntilSaved(monotonicNow() + 20s));
  EXPECT_THAT(problemOf(mapper), HasSubstr("the map is too large for a picture: its 180"));
  EXPECT_FALSE(fs::exists(folder / "map.yaml"));
}

TEST_F(MapFiles, KeepNobodyWaitingForADiskThatHangs) {
  config.output.map = folder / "map";
  ASSERT_EQ(mkfifo((folder / "map.pgm.new").c_str(), 0600), 0);  // whoever opens it to write waits
  MapperThread mapper(config, channels.mapper(), clock);
  mapper.worker().start();
  channels.requests.save = true;
  ASSERT_TRUE(waitUntil([&] { return mapper.storage(monotonicNow()).waiting > 200ms; }));
  const std::uint64_t ticks = mapper.worker().ticks();
  EXPECT_TRUE(waitUntil([&] { return mapper.worker().ticks() > ticks + 5; }));
  EXPECT_EQ(channels.requests.saved, SaveOutcome::kNone);
  std::ifstream disk(folder / "map.pgm.new", std::ios::binary);  // it answers
  std::string all(std::istreambuf_iterator<char>(disk), {});
  EXPECT_TRUE(waitUntil([&] { return channels.requests.saved == SaveOutcome::kSaved; }));
}

/// A mapper thread that draws scans, and what it hands to the bus.
class MapTiles : public testing::Test {
 protected:
  void draw(std::int32_t map_id, int id, const Pose2& T_map_base, Timestamp stamp = monotonicNow()) {
    auto scan = std::make_shared<StoredScan>();
    for (const float bearing : {0.1F, 0.2F, 0.3F}) {
      scan->points.push_back({.x = 2.0F * std::cos(bearing), .y = 2.0F * std::sin(bearing)});
    }
    auto change = std::make_shared<MapChange>();
    change->map_id = map_id;
    change->stamp = stamp;
    change->scans.push_back({id, T_map_base, scan});
    ASSERT_TRUE(channels->map.changes.tryPush(change));
  }
  /// Places of the tiles that come until so many are there, with all that the thread's tick sends beside them.
  std::vector<std::pair<int, int>> tiles(std::size_t count) {
    std::vector<std::pair<int, int>> places;
    const auto take = [&] {
      channels->tiles.map.drain([&](const map_tile_t& tile) {
        places.emplace_back(tile.column, tile.row);
        map_ids.push_back(tile.map_id);
      });
      return places.size() >= count;
    };
    EXPECT_TRUE(waitUntil(take)) << places.size() << " of " << count;
    const std::uint64_t tick = mapper.worker().ticks();  // perhaps in the middle of its tiles
    EXPECT_TRUE(waitUntil([&] { return mapper.worker().ticks() > tick; }));
    take();
    return places;
  }
  map_meta_t meta() {
    std::optional<map_meta_t> last;
    EXPECT_TRUE(waitUntil([&] {
      channels->tiles.meta.drain([&](const map_meta_t& meta) { last = meta; });
      return last.has_value();
    }));
    return last.value_or(map_meta_t{});
  }

  Config config;
  WallClock clock;
  std::unique_ptr<Channels> channels = std::make_unique<Channels>();
  MapperThread mapper{config, channels->mapper(), clock};
  std::vector<std::int32_t> map_ids;
};

TEST_F(MapTiles, AreSentWhenTheyChangeAndAllOfThemWhenAskedFor) {
  mapper.worker().start();
  const Timestamp stamp = monotonicNow();
  draw(3, 0, {0.5, 0.5, 0.0}, stamp);
  EXPECT_THAT(tiles(1), testing::ElementsAre(std::pair(0, 0)));
  const map_meta_t first = meta();
  EXPECT_EQ(first.map_id, 3);
  EXPECT_EQ(first.keyframes, 1);
  EXPECT_EQ(first.tiles, 1);
  EXPECT_EQ(first.utime, clock.utime(stamp));
  draw(3, 1, {-5.0, 0.5, 3.1});  // elsewhere
  for (const auto& [column, row] : tiles(1)) EXPECT_LT(column, 0) << "the tile that has not changed is not sent again";
  const std::int32_t all = meta().tiles;
  ASSERT_GT(all, 1);
  channels->requests.refresh = true;
  const auto again = tiles(static_cast<std::size_t>(all));
  EXPECT_THAT(again, testing::Contains(std::pair(0, 0)));
  EXPECT_EQ(again.size(), static_cast<std::size_t>(all));
  EXPECT_EQ(meta().tiles, all);
  EXPECT_FALSE(channels->requests.refresh);
  EXPECT_EQ(channels->map_keyframes, 2);
}

TEST_F(MapTiles, OfAnotherMapBeginAnew) {
  mapper.worker().start();
  draw(3, 0, {0.5, 0.5, 0.0});
  tiles(1);
  meta();
  draw(4, 0, {40.0, 0.5, 0.0});
  for (const auto& [column, row] : tiles(1)) EXPECT_GT(column, 5);
  EXPECT_EQ(map_ids.back(), 4);
  const map_meta_t now = meta();
  EXPECT_EQ(now.map_id, 4);
  EXPECT_EQ(now.keyframes, 1);
  EXPECT_GT(now.column_min, 5) << "nothing of the other map is left";
}

TEST_F(MapTiles, ComeInLayersWhereTheDepthCameraHasSeen) {
  auto view = std::make_shared<DepthView>();
  view->beams.push_back({.bearing = 0.0F, .range = 1.0F, .free_from = 0.5F, .hit = true});
  auto change = std::make_shared<MapChange>();
  change->map_id = 3;
  change->views.push_back({.keyframe = 0, .T_map_keyframe = {0.5, 0.5, 0.0}, .T_keyframe_base = {}, .view = view});
  draw(3, 0, {0.5, 0.5, 0.0});
  draw(3, 1, {-40.0, 0.5, 0.0});  // by the lidar alone
  ASSERT_TRUE(channels->map.changes.tryPush(change));
  mapper.worker().start();
  std::vector<std::pair<int, int>> lidar, depth;
  const auto take = [&](auto& queue, auto& places) {
    queue.drain([&](const map_tile_t& tile) { places.emplace_back(tile.column, tile.row); });
  };
  ASSERT_TRUE(waitUntil([&] {
    take(channels->tiles.lidar, lidar);
    take(channels->tiles.depth, depth);
    return !lidar.empty() && !depth.empty();
  }));
  const std::uint64_t tick = mapper.worker().ticks();
  ASSERT_TRUE(waitUntil([&] { return mapper.worker().ticks() > tick + 2; }));
  take(channels->tiles.lidar, lidar);
  take(channels->tiles.depth, depth);
  EXPECT_THAT(lidar, testing::ElementsAre(std::pair(0, 0)));
  EXPECT_THAT(depth, testing::ElementsAre(std::pair(0, 0)));
}

TEST_F(MapTiles, ComeAFewAtATime) {
  for (int i = 0; i < 60; ++i) draw(3, i, {4.0 * i, 0.5, 0.0});
  mapper.worker().start();
  const std::size_t all = 40;
  std::size_t most = 0, count = 0;
  for (std::uint64_t tick = 0; count < all;) {
    ASSERT_TRUE(waitUntil([&] { return mapper.worker().ticks() > tick; }));
    tick = mapper.worker().ticks();
    const std::size_t burst = channels->tiles.map.drain([](const map_tile_t&) {});
    if (tick == 1) most = burst;
    count += burst;
  }
  EXPECT_LE(most, 40U) << "a burst of a whole map would overrun who listens";
}

}  // namespace
}  // namespace slam::mapper_thread_test
