// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_codec.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <zlib.h>

#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam {
namespace {

using test::ChangingMap;
using test::refusalOf;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

MapState decoded(const MapState& map) {
  MapState back;
  decodeKeyframes(encodeKeyframes(map), back);
  decodeEdges(encodeEdges(map), back);
  decodeState(encodeState(map), back);
  back.grid = decodeGrid(encodeGrid(map.grid), {});
  return back;
}

/// A grid's bytes as anybody may write them.
std::string packed(const std::string& raw, std::uint64_t claimed, double resolution = 0.1) {
  std::string compressed(::compressBound(raw.size()), '\0');
  uLongf size = compressed.size();
  ::compress(reinterpret_cast<Bytef*>(compressed.data()), &size, reinterpret_cast<const Bytef*>(raw.data()),
             raw.size());
  compressed.resize(size);
  BinaryWriter out;
  out.put(resolution);
  out.put(claimed);
  out.putBytes(compressed);
  return out.take();
}

std::string tileAt(int column, int row) {
  BinaryWriter out;
  out.put(std::int32_t{column});
  out.put(std::int32_t{row});
  for (int i = 0; i < OccupancyGrid::kTileSide * OccupancyGrid::kTileSide; ++i) out.put(LogOdds{100});
  return out.take();
}

TEST(MapCodec, GivesBackTheMap) {
  ChangingMap changing(6);
  changing.addKeyframe(false);
  changing.map.keyframes.graph().revoke(5);
  changing.map.T_map_base = {-1.0 / 3.0, 1e-9, -3.0};
  changing.map.gyro_bias = -1.23456789012345e-5;
  const MapState back = decoded(changing.map);
  EXPECT_EQ(test::differenceOf(changing.map, back), "");
  EXPECT_EQ(back.grid_keyframes, changing.map.grid_keyframes);
  EXPECT_TRUE(test::sameCells(changing.map.grid, back.grid));
}

TEST(MapCodec, GivesBackAnEmptyMap) {
  MapState empty;
  const MapState back = decoded(empty);
  EXPECT_EQ(test::differenceOf(empty, back), "");
  EXPECT_EQ(back.grid.tiles().tileCount(), 0);
}

TEST(MapCodec, KeepsTilesOnAllSidesOfTheOrigin) {
  OccupancyGrid grid(test::smallGrid());
  const std::vector<CellIndex> cells = {{-1, -1}, {0, 0}, {63, 64}, {-64, -65}, {-300, 500}};
  for (const CellIndex& cell : cells) grid.set(cell, static_cast<LogOdds>(cell.column - 7));
  EXPECT_TRUE(test::sameCells(grid, decodeGrid(encodeGrid(grid), {})));
}

TEST(MapCodec, RefusesEveryPartThatIsCutOff) {
  ChangingMap changing;
  const auto refuses = [](const std::string& bytes, auto&& decode) {
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_THROW(decode(std::string_view(bytes).substr(0, size)), std::runtime_error) << size;
    }
  };
  refuses(encodeKeyframes(changing.map), [](std::string_view bytes) {
    MapState map;
    decodeKeyframes(bytes, map);
  });
  refuses(encodeEdges(changing.map), [&](std::string_view bytes) {
    MapState map = changing.copy();
    decodeEdges(bytes, map);
  });
  refuses(encodeGrid(changing.map.grid), [](std::string_view bytes) { decodeGrid(bytes, {}); });
}

TEST(MapCodec, RefusesNumbersThatAreNotFinite) {
  ChangingMap changing(2);
  MapState bad = changing.copy(), into;
  bad.keyframes.graph().setPose(1, {0.0, kNan, 0.0});
  EXPECT_THAT(refusalOf([&] { decodeKeyframes(encodeKeyframes(bad), into); }), testing::HasSubstr("not finite"));
  Edge edge;
  edge.to = 1;
  edge.information(2, 2) = std::numeric_limits<double>::infinity();
  changing.map.keyframes.graph().addEdge(edge);
  EXPECT_THAT(refusalOf([&] { decodeEdges(encodeEdges(changing.map), bad); }), testing::HasSubstr("not finite"));
  bad.gyro_bias = kNan;
  EXPECT_THROW(decodeState(encodeState(bad), into), std::runtime_error);
  EXPECT_THROW(decodeGrid(packed(tileAt(0, 0), tileAt(0, 0).size(), kNan), {}), std::runtime_error);
}

TEST(MapCodec, RefusesEdgesAndPosesOfKeyframesThatAreNotThere) {
  const ChangingMap changing(4);
  for (const auto& [from, to] : {std::pair{0, 4}, {-1, 0}, {2, 2}, {4, 0}, {0, 1 << 30}}) {
    BinaryWriter out;
    Edge edge;
    edge.from = from;
    edge.to = to;
    encodeEdge(out, edge);
    MapState map = changing.copy();
    BinaryReader in(out.bytes());
    EXPECT_THROW(decodeEdge(in, map), std::runtime_error) << from << " to " << to;
  }
  BinaryWriter out;
  encodePoses(out, std::vector<Pose2>(5));
  MapState map = changing.copy();
  BinaryReader in(out.bytes());
  EXPECT_THROW(decodePoses(in, map), std::runtime_error);
}

TEST(MapCodec, TakesNoMoreMemoryThanTheBytesAreWorth) {
  const std::string tile = tileAt(0, 0);
  EXPECT_NO_THROW(decodeGrid(packed(tile, tile.size()), {}));
  EXPECT_THROW(decodeGrid(packed(tile, 2 * tile.size()), {}), std::runtime_error);
  EXPECT_THROW(decodeGrid(packed(tile, tile.size() << 18), {}), std::runtime_error) << "gigabytes claimed";
  EXPECT_THROW(decodeGrid(packed(tile, std::numeric_limits<std::uint64_t>::max()), {}), std::runtime_error);
  const std::string far = tileAt(-(1 << 20), -(1 << 20)) + tileAt(1 << 20, 1 << 20);
  EXPECT_THROW(decodeGrid(packed(far, far.size()), {}), std::runtime_error) << "a directory of terabytes";
  const std::string farther = tileAt(std::numeric_limits<int>::min(), 0);
  EXPECT_THROW(decodeGrid(packed(farther, farther.size()), {}), std::runtime_error);
}

TEST(MapCodec, RefusesADepthLayerFarFromTheLidarLayer) {
  MapState map;
  map.grid.set({0, 0}, 100);
  const std::string no_views(8, '\0');
  const std::string near = tileAt(3, 3), far = tileAt(-256, 65436);  // together a directory of 134 MB
  EXPECT_THROW(decodeDepth(no_views + packed(far, far.size()), map), std::runtime_error);
  EXPECT_NO_THROW(decodeDepth(no_views + packed(near, near.size()), map));
}

TEST(MapCodec, RefusesAStateThatSaysTooLittle) {
  const std::string whole = encodeState(ChangingMap().map);
  MapState map;
  for (const char* key : {"T_map_base", "utime", "gyro_bias", "T_base_lidar", "lidar_range_max", "grid_keyframes"}) {
    std::string text = whole;
    text.insert(text.find(std::string("\n").append(key)) + 1, "other_");
    EXPECT_THAT(refusalOf([&] { decodeState(text, map); }), testing::HasSubstr(key));
  }
  for (const char* text : {"utime = ", "utime = [", "= 3", "T_map_base = [1.0, 2.0]", "[/F"}) {
    EXPECT_THROW(decodeState(text, map), std::runtime_error) << text;
  }
}

TEST(MapCodec, SurvivesGarbage) {
  ChangingMap changing;
  const std::string parts[] = {encodeKeyframes(changing.map), encodeEdges(changing.map), encodeGrid(changing.map.grid),
                               encodeState(changing.map)};
  std::mt19937 random(11);
  std::uniform_int_distribution<int> byte(0, 255), length(0, 300), kind(0, 2);
  for (int round = 0; round < 3000; ++round) {
    const std::size_t part = static_cast<std::size_t>(round) % 4;
    std::string bytes = parts[part];
    switch (kind(random)) {
      case 0:  // nothing but noise
        bytes.resize(static_cast<std::size_t>(length(random)));
        for (char& c : bytes) c = static_cast<char>(byte(random));
        break;
      case 1:  // a few bytes flipped
        for (int i = 0; i < 4; ++i)
          bytes[std::uniform_int_distribution<std::size_t>(0, bytes.size() - 1)(random)] =
              static_cast<char>(byte(random));
        break;
      default:  // the count, which comes first
        for (std::size_t i = 0; i < 16; ++i)
          bytes[i] = static_cast<char>(byte(random) & (byte(random) > 128 ? 0xFF : 0));
    }
    try {
      MapState map = changing.copy();
      if (part == 0) decodeKeyframes(bytes, map);
      if (part == 1) decodeEdges(bytes, map);
      if (part == 2) decodeGrid(bytes, {});
      if (part == 3) decodeState(bytes, map);
      for (const Edge& edge : map.keyframes.graph().edges()) {
        ASSERT_LT(std::max(edge.from, edge.to), map.keyframes.size());
        ASSERT_TRUE(edge.information.allFinite());
      }
      for (const Pose2& pose : map.keyframes.graph().poses()) ASSERT_TRUE(std::isfinite(pose.x + pose.y + pose.theta));
      ASSERT_TRUE(std::isfinite(map.gyro_bias));
    } catch (const std::runtime_error& refusal) {
      ASSERT_NE(std::string(refusal.what()), "");
    }
  }
}

TEST(MapCodec, DepthComesBackAsItWas) {
  MapState map;
  auto scan = std::make_shared<StoredScan>();
  map.keyframes.add(scan, {1.0, 2.0, 0.5});
  map.in_map.push_back(1);
  map.views.push_back(test::viewFrom(0, {1.0, 2.0, 0.5}));
  const auto& view = map.views.front().view;
  for (const MapView& drawn : map.views) map.grid.add(drawn.T_map_base() * view->T_base_depth, *view);
  const std::string bytes = encodeDepth(map);

  MapState back;
  back.keyframes.add(scan, {1.0, 2.0, 0.5});
  back.in_map.push_back(1);
  decodeDepth(bytes, back);
  ASSERT_EQ(back.views.size(), 1U);
  const DepthView& read = *back.views.front().view;
  EXPECT_EQ(read.stamp, view->stamp);
  EXPECT_EQ(read.T_base_depth, view->T_base_depth);
  EXPECT_EQ(back.views.front().T_keyframe_base, map.views.front().T_keyframe_base);
  ASSERT_EQ(read.beams.size(), 2U);
  EXPECT_EQ(read.beams[0].range, 2.0F);
  EXPECT_TRUE(read.beams[0].hit);
  ASSERT_EQ(read.surfaces.size(), 1U);
  EXPECT_EQ(read.surfaces[0].to, 2.9F);
  EXPECT_EQ(encodeDepth(back), bytes) << "the layer, too";

  // Cut off anywhere, or of keyframes that are not there, it is refused, and the map stays as it is.
  for (std::size_t size = 0; size < bytes.size(); size += 3) {
    MapState other;
    other.keyframes.add(scan, {});
    other.in_map.push_back(1);
    EXPECT_THROW(decodeDepth(std::string_view(bytes).substr(0, size), other), std::runtime_error) << size;
    EXPECT_TRUE(other.views.empty());
    EXPECT_EQ(other.grid.tiles().tileCount(), 0);
  }
  MapState empty;
  EXPECT_THROW(decodeDepth(bytes, empty), std::runtime_error);
}

TEST(MapCodec, TakesNoViewThatNoCameraHas) {
  MapState map;
  map.keyframes.add(std::make_shared<StoredScan>(), {});
  map.in_map.push_back(1);
  const auto taken = [&](auto&& change) {
    MapView view = test::viewFrom(0, {});
    auto depth = std::make_shared<DepthView>(*view.view);
    change(view, *depth);
    view.view = depth;
    BinaryWriter out;
    encodeView(out, view);
    BinaryReader in(out.bytes());
    try {
      decodeView(in, map);
      return true;
    } catch (const std::runtime_error&) {
      return false;
    }
  };
  const auto nan = static_cast<float>(kNan);
  EXPECT_TRUE(taken([](MapView&, DepthView&) {}));
  EXPECT_TRUE(taken([](MapView&, DepthView& d) { d.beams[0].free_from = 0.0F, d.beams[0].range = 999.0F; }));
  EXPECT_FALSE(taken([](MapView&, DepthView& d) { d.beams[0].range = 1000.0F; }));
  EXPECT_FALSE(taken([](MapView&, DepthView& d) { d.beams[0].free_from = -0.01F; }));
  EXPECT_FALSE(taken([](MapView&, DepthView& d) { d.beams[0].free_from = 2.01F; })) << "behind its hit";
  EXPECT_FALSE(taken([&](MapView&, DepthView& d) { d.beams[1].bearing = nan; }));
  EXPECT_FALSE(taken([&](MapView&, DepthView& d) { d.beams[1].range = nan; }));
  EXPECT_FALSE(taken([](MapView&, DepthView& d) { d.surfaces[0].to = 1000.0F; }));
  EXPECT_FALSE(taken([](MapView&, DepthView& d) { d.surfaces[0].from = -0.01F; }));
  EXPECT_FALSE(taken([](MapView&, DepthView& d) { d.surfaces[0].from = 3.0F; })) << "behind its end";
  EXPECT_FALSE(taken([&](MapView&, DepthView& d) { d.surfaces[0].bearing = nan; }));
  EXPECT_FALSE(taken([](MapView& v, DepthView&) { v.keyframe = 1; }));
  EXPECT_FALSE(taken([](MapView& v, DepthView&) { v.keyframe = -1; }));
  EXPECT_FALSE(taken([](MapView& v, DepthView&) { v.T_keyframe_base.theta = kNan; }));
}

TEST(MapCodec, TakesNoTileFurtherOffThanItCanCount) {
  constexpr int kFarthest = 1 << 20;
  for (const auto& [column, row] : {std::pair(kFarthest, 0), {-kFarthest, 0}, {0, kFarthest}, {0, -kFarthest}}) {
    const std::string last = tileAt(column, row);
    EXPECT_NO_THROW(decodeGrid(packed(last, last.size()), {})) << column << ' ' << row;
    const std::string beyond = tileAt(column + (column > 0) - (column < 0), row + (row > 0) - (row < 0));
    EXPECT_THROW(decodeGrid(packed(beyond, beyond.size()), {}), std::runtime_error) << column << ' ' << row;
  }
}

TEST(MapCodec, TakesEveryKindOfEdgeAndNoOther) {
  const ChangingMap changing(3);
  for (int kind = 0; kind < 4; ++kind) {
    Edge edge;
    edge.to = 2;
    edge.kind = static_cast<EdgeKind>(kind);
    BinaryWriter out;
    encodeEdge(out, edge);
    BinaryReader in(out.bytes());
    MapState map = changing.copy();
    const bool known = kind <= static_cast<int>(EdgeKind::kLoopClosure);
    if (known) {
      EXPECT_NO_THROW(decodeEdge(in, map)) << kind;
    } else {
      EXPECT_THROW(decodeEdge(in, map), std::runtime_error) << kind;
    }
  }
}

TEST(MapCodec, LeavesTheLidarsLayerWhereTheCameraSawSomethingToo) {
  MapState map;
  map.keyframes.add(std::make_shared<StoredScan>(), {});
  map.in_map.push_back(1);
  map.grid.set({3, 4}, -700, 400);
  MapState back;
  back.keyframes.add(std::make_shared<StoredScan>(), {});
  back.in_map.push_back(1);
  back.grid = decodeGrid(encodeGrid(map.grid), {});
  decodeDepth(encodeDepth(map), back);
  EXPECT_EQ(back.grid.tiles().read({3, 4}).lidar, -700);
  EXPECT_EQ(back.grid.tiles().read({3, 4}).depth, 400);
}

}  // namespace
}  // namespace slam
