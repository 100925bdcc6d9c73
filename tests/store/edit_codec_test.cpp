// SPDX-License-Identifier: BSD-3-Clause
#include "store/edit_codec.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::edit_codec_test {
namespace {

using test::refusalOf;
using testing::HasSubstr;

MapState editedMap() {
  test::ChangingMap changing(5);
  MapState map = changing.copy();
  map.views = {test::viewFrom(1, map.keyframes.pose(1))};
  for (const EditKind kind : {EditKind::kErase, EditKind::kFree, EditKind::kNoGo, EditKind::kRoom})
    EXPECT_EQ(test::edit(map, test::squareEdit(kind, 1.0, 0.5)), "");
  EditCommand place = test::squareEdit(EditKind::kPlace, 0.0, 0.0);
  place.request.points.resize(1);
  place.request.name = "dock";
  place.request.theta = 1.0;
  place.request.sigma = {0.1, 0.2, 0.3};
  EXPECT_EQ(test::edit(map, place), "");
  place.kind = EditCommand::kUndo;
  EXPECT_EQ(test::edit(map, place), "");
  map.views.push_back(test::viewFrom(2, map.keyframes.pose(2)));
  map.views.back().edit = map.edits.made;
  return map;
}

/// The map without its edits, as its other files have it.
MapState plain(const MapState& map) {
  MapState whole;
  for (int id = 0; id < map.keyframes.size(); ++id)
    whole.keyframes.add(std::make_shared<StoredScan>(wholeScan(map, id)), map.keyframes.pose(id));
  for (const Edge& edge : map.keyframes.graph().edges()) whole.keyframes.graph().addEdge(edge);
  whole.in_map = map.in_map;
  whole.views = map.views;
  for (MapView& view : whole.views) view.edit = 0;
  return whole;
}

TEST(EditCodec, WhatIsWrittenIsRead) {
  const MapState map = editedMap();
  ASSERT_FALSE(map.edits.whole.empty());
  MapState again = plain(map);
  decodeEdits(encodeEdits(map), again);
  EXPECT_EQ(again.edits.whole.size(), map.edits.whole.size());
  EXPECT_EQ(again.views[0].edit, 0);
  EXPECT_EQ(again.views[1].edit, map.edits.made);
  again.T_map_base = map.T_map_base;
  again.gyro_bias = map.gyro_bias;
  again.body = map.body;
  again.T_base_lidar = map.T_base_lidar;
  again.range_max = map.range_max;
  again.utime = map.utime;
  EXPECT_EQ(test::differenceOf(again, map), "");
  EXPECT_EQ(encodeEdits(again), encodeEdits(map));
}

TEST(EditCodec, CutOffAnywhereIsRefusedAndChangesNothing) {
  const MapState map = editedMap();
  const std::string whole = encodeEdits(map);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    MapState again = plain(map);
    EXPECT_NE(refusalOf([&] { decodeEdits(whole.substr(0, size), again); }), "") << size;
    EXPECT_TRUE(again.edits.empty());
  }
}

TEST(EditCodec, RefusesWhatCannotBe) {
  const auto refusal = [](auto&& change) {
    MapState map = editedMap();
    change(map.edits);
    return refusalOf([&] { encodeEdits(map); });
  };
  EXPECT_THAT(refusal([](MapEdits& edits) { edits.edits[0].corners[0].keyframe = 99; }), HasSubstr("not there"));
  EXPECT_THAT(refusal([](MapEdits& edits) { edits.edits[1].corners[0].p_keyframe.x() = std::nan(""); }),
              HasSubstr("too far"));
  EXPECT_THAT(refusal([](MapEdits& edits) { edits.edits[0].T_keyframe_map[-1] = {}; }), HasSubstr("not there"));
  EXPECT_THAT(refusal([](MapEdits& edits) { edits.edits[1].outline = {{0.0, 0.0}}; }), HasSubstr("outline"));
  EXPECT_THAT(refusal([](MapEdits& edits) { edits.edits[3].name = std::string(65, 'k'); }), HasSubstr("too long"));
  EXPECT_THAT(refusal([](MapEdits& edits) { edits.edits[4].sigma.x() = -1.0; }), HasSubstr("sigma"));
  EXPECT_THAT(refusal([](MapEdits& edits) { edits.edits[2].id = 1; }), HasSubstr("order"));
  EXPECT_THAT(refusal([](MapEdits& edits) { edits.steps[0].id = 77; }), HasSubstr("step"));
  EXPECT_THAT(refusal([](MapEdits& edits) { edits.done = 100; }), HasSubstr("undoes more"));
  EXPECT_THAT(refusal([](MapEdits& edits) { edits.made = -1; }), HasSubstr("counts"));
}

}  // namespace
}  // namespace slam::edit_codec_test
