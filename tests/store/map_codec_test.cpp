// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_codec.hpp"

#include <cmath>
#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iomanip>
#include <limits>
#include <random>
#include <sstream>
#include <zlib.h>

#include "core/plausibility.hpp"
#include "support/absurd.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::map_codec_test {
namespace {

using test::ChangingMap;
using test::refusalOf;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Edge between0And(int to) {
  Edge edge;
  edge.to = to;
  return edge;
}

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

/// The bytes with another number in the place of the one that is `mark` there.
template <typename Number>
std::string replaced(std::string bytes, Number mark, Number by) {
  std::string wanted(sizeof mark, '\0'), now(sizeof mark, '\0');
  std::memcpy(wanted.data(), &mark, sizeof mark);
  std::memcpy(now.data(), &by, sizeof by);
  const auto at = bytes.find(wanted);
  EXPECT_NE(at, std::string::npos);
  return bytes.replace(at, sizeof mark, now);
}

/// That a number of a part, which `mark` stands for, is neither written nor read where it is one of `absurd`.
/// @param set puts it into a map
template <typename Number, typename Set, typename Encode, typename Decode>
void expectNeither(Number mark, const std::vector<double>& absurd, Set&& set, Encode&& encode, Decode&& decode) {
  ChangingMap good(3);
  set(good.map, mark);
  const std::string bytes = encode(good.map);
  MapState into = good.copy();
  EXPECT_NO_THROW(decode(bytes, into));
  for (const double value : absurd) {
    const auto number = static_cast<Number>(value);
    ChangingMap bad(3);
    set(bad.map, number);
    EXPECT_THROW(encode(bad.map), ImplausibleMap) << value;
    into = good.copy();
    EXPECT_THROW(decode(replaced(bytes, mark, number), into), std::runtime_error) << value;
  }
}

TEST(MapCodec, NeitherWritesNorReadsWhatCannotBe) {
  const auto far = test::absurdNumbers(kPlausible.stored_farthest), turned = test::absurdNumbers(kPlausible.turn),
             seen = test::absurdNumbers(kPlausible.range), sure = test::absurdNumbers(kPlausible.information),
             mounted = test::absurdNumbers(kPlausible.mounting);
  const auto readKeyframes = [](const std::string& bytes, MapState& map) {
    map = MapState();
    decodeKeyframes(bytes, map);
  };
  const auto poses = [](const MapState& map) {
    BinaryWriter out;
    encodePoses(out, map.keyframes.graph().poses());
    return out.take();
  };
  const auto readPoses = [](const std::string& bytes, MapState& map) {
    BinaryReader in(bytes);
    decodePoses(in, map);
  };
  for (double Pose2::*coordinate : {&Pose2::x, &Pose2::y, &Pose2::theta}) {
    const auto& absurd = coordinate == &Pose2::theta ? turned : far;
    const auto setPose = [=](MapState& map, double value) {
      Pose2 pose{1.0, 2.0, 0.3};
      pose.*coordinate = value;
      map.keyframes.graph().setPose(1, pose);
    };
    expectNeither(0.123456789, absurd, setPose, encodeKeyframes, readKeyframes);
    expectNeither(0.123456789, absurd, setPose, poses, readPoses);
    const auto setEdge = [=](MapState& map, double value) {
      Edge edge = between0And(2);
      edge.T_from_to.*coordinate = value;
      map.keyframes.graph().addEdge(edge);
    };
    const auto& apart = coordinate == &Pose2::theta ? turned : test::absurdNumbers(2.0 * kPlausible.stored_farthest);
    expectNeither(0.123456789, apart, setEdge, encodeEdges, decodeEdges);
    const auto setLidar = [=](MapState& map, double value) {
      auto scan = std::make_shared<StoredScan>(*map.keyframes.scan(1));
      scan->T_base_lidar.*coordinate = value;
      map.keyframes.setScan(1, scan);
    };
    expectNeither(0.123456789, coordinate == &Pose2::theta ? turned : mounted, setLidar, encodeKeyframes,
                  readKeyframes);
  }
  for (float Keyframe::Point::*coordinate : {&Keyframe::Point::x, &Keyframe::Point::y}) {
    const auto setPoint = [=](MapState& map, float value) {
      auto scan = std::make_shared<StoredScan>(*map.keyframes.scan(1));
      scan->points[1].*coordinate = value;
      map.keyframes.setScan(1, scan);
    };
    expectNeither(0.123F, seen, setPoint, encodeKeyframes, readKeyframes);
  }
  const auto setInformation = [](MapState& map, double value) {
    Edge edge = between0And(2);
    edge.information(1, 2) = edge.information(2, 1) = value;
    map.keyframes.graph().addEdge(edge);
  };
  expectNeither(0.123456789, sure, setInformation, encodeEdges, decodeEdges);
}

TEST(MapCodec, NeitherWritesNorReadsAStateThatCannotBe) {
  const ChangingMap good(3);
  const auto expect = [&](const char* key, const std::vector<double>& absurd, auto&& set) {
    for (const double value : absurd) {
      MapState bad = good.copy();
      set(bad, value);
      EXPECT_THROW(encodeState(bad), ImplausibleMap) << key << ' ' << value;
      // As an older slamd has written it, or a person.
      std::string text = encodeState(good.map);
      const auto line = text.find(std::string(key) + " = "), end = text.find('\n', line);
      std::ostringstream number;
      number << std::scientific << std::setprecision(17) << value;
      const bool pose = key[0] == 'T';
      text.replace(line, end - line,
                   std::string(key) + " = " + (pose ? "[0.5, " + number.str() + ", 0.5]" : number.str()));
      MapState into = good.copy();
      EXPECT_THROW(decodeState(text, into), std::runtime_error) << text;
      EXPECT_EQ(test::differenceOf(into, good.map), "") << "it stays as it was";
    }
  };
  expect("T_map_base", test::absurdNumbers(kPlausible.stored_farthest),
         [](MapState& map, double value) { map.T_map_base.y = value; });
  expect("T_base_lidar", test::absurdNumbers(kPlausible.mounting),
         [](MapState& map, double value) { map.T_base_lidar.y = value; });
  expect("gyro_bias", test::absurdNumbers(kPlausible.turn_rate),
         [](MapState& map, double value) { map.gyro_bias = value; });
  expect("lidar_range_max", test::absurdNumbers(kPlausible.range),
         [](MapState& map, double value) { map.range_max = value; });
  MapState early = good.copy();
  early.utime = -1;
  EXPECT_THROW(encodeState(early), ImplausibleMap);
}

TEST(MapCodec, NeitherWritesNorReadsAGridThatCannotBe) {
  for (const double resolution : {0.0, -0.05, 1e-300, 0.0009, 1.1, 1e6, kNan, HUGE_VAL}) {
    OccupancyGridConfig config;
    config.resolution = resolution;
    EXPECT_THROW(encodeGrid(OccupancyGrid(config)), ImplausibleMap) << resolution;
    const std::string tile = tileAt(0, 0);
    EXPECT_THROW(decodeGrid(packed(tile, tile.size(), resolution), {}), std::runtime_error) << resolution;
  }
  OccupancyGrid grid(test::smallGrid());
  constexpr int kFarthest = 210'000;  // [cells] 21 km
  grid.set({kFarthest - 64, -kFarthest + 64}, 100);
  EXPECT_NO_THROW(encodeGrid(grid));
  grid.set({kFarthest + 64, 0}, 100);
  EXPECT_THROW(encodeGrid(grid), ImplausibleMap);
}

TEST(MapCodec, TilesFarApartTakeTheMemoryOfTiles) {
  // A box around them would have 4e7 tiles: 320 MB of a directory, and 1 TB of cells.
  const std::string tiles = tileAt(-3200, -3200) + tileAt(3200, 3200);
  const OccupancyGrid grid = decodeGrid(packed(tiles, tiles.size()), {});
  EXPECT_EQ(grid.tiles().tileCount(), 2);
  MapState map;
  map.grid = grid.clone();
  const std::string near = tileAt(3, -3200);
  EXPECT_NO_THROW(decodeDepth(std::string(8, '\0') + packed(near, near.size()), map));
  EXPECT_EQ(map.grid.tiles().tileCount(), 3);
}

TEST(MapCodec, RefusesEdgesAndPosesOfKeyframesThatAreNotThere) {
  const ChangingMap changing(4);
  for (const auto& [from, to] : {std::pair{0, 4}, {-1, 0}, {2, 2}, {4, 0}, {0, 1 << 30}}) {
    BinaryWriter out;
    const Edge edge = between0And(1);
    encodeEdge(out, edge);
    std::string bytes = out.take();
    std::memcpy(bytes.data(), &from, sizeof from);
    std::memcpy(bytes.data() + sizeof from, &to, sizeof to);
    MapState map = changing.copy();
    BinaryReader in(bytes);
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
  const std::string farther = tileAt(std::numeric_limits<int>::min(), 0);
  EXPECT_THROW(decodeGrid(packed(farther, farther.size()), {}), std::runtime_error);
}

TEST(MapCodec, RefusesAStateThatHoldsTooLittle) {
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
    try {  // what cannot be read is not written either
      encodeView(out, view);
      BinaryReader in(out.bytes());
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
  for (const double bad : test::absurdNumbers(2.0 * kPlausible.stored_farthest))
    EXPECT_FALSE(taken([=](MapView& v, DepthView&) { v.T_keyframe_base.x = bad; })) << bad;
  for (const double bad : test::absurdNumbers(kPlausible.mounting))
    EXPECT_FALSE(taken([=](MapView&, DepthView& d) { d.T_base_depth.y = bad; })) << bad;
  EXPECT_FALSE(taken([](MapView& v, DepthView&) { v.T_keyframe_base.theta = kNan; }));
}

TEST(MapCodec, TakesNoTileFurtherOffThanAMapReaches) {
  constexpr int kFarthest = 21'000 * 10 / OccupancyGrid::kTileSide;  // [tiles] of 6.4 m
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
    BinaryWriter out;
    encodeEdge(out, between0And(2));
    std::string bytes = out.take();
    bytes[bytes.size() - 2] = static_cast<char>(kind);
    BinaryReader in(bytes);
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
}  // namespace slam::map_codec_test
