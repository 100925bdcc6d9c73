// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/maps/edit_board.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <nlohmann/json.hpp>

#include "slam/edits/map_edit.hpp"

namespace slam::edit_board_test {
namespace {

map_edit_t edit(int index, int of, int revision = 1) {
  map_edit_t message{};
  message.map_id = 4;
  message.revision = revision;
  message.edits = of;
  message.index = index;
  message.id = index + 1;
  message.kind = "zone";
  message.npoints = 3;
  message.x = {0.0, 1.0, 1.0 + index};
  message.y = {0.0, 0.0, 1.0};
  return message;
}

class Board : public testing::Test {
 protected:
  Board() { board_.begin(4); }
  EditBoard board_;
};

TEST_F(Board, ShowsARevisionOnceItIsWhole) {
  const auto before = board_.serial();
  EXPECT_TRUE(board_.take(edit(1, 2)));
  EXPECT_EQ(board_.serial(), before);
  EXPECT_TRUE(board_.take(edit(0, 2)));
  EXPECT_EQ(board_.serial(), before + 1);
  ASSERT_EQ(board_.edits().size(), 2U);
  EXPECT_EQ(board_.edits()[1].id, 2);
  for (int i : {0, 1}) EXPECT_TRUE(board_.take(edit(i, 2)));  // again, with the next refresh
  EXPECT_EQ(board_.serial(), before + 1);
  map_edit_t moved = edit(1, 2);
  moved.x[0] = 0.1;
  EXPECT_TRUE(board_.take(moved));
  EXPECT_EQ(board_.serial(), before + 2);
  EXPECT_EQ(board_.edits()[1].x[0], 0.1);
}

TEST_F(Board, IsEmptyBehindTheLastUndoAndInAnotherMap) {
  EXPECT_TRUE(board_.take(edit(0, 1)));
  map_edit_t none{};
  none.map_id = 4;
  none.revision = 2;
  EXPECT_TRUE(board_.take(none));
  EXPECT_TRUE(board_.edits().empty());
  EXPECT_TRUE(board_.take(edit(0, 1, 3)));
  EXPECT_EQ(board_.edits().size(), 1U);
  board_.begin(5);
  EXPECT_TRUE(board_.edits().empty());
  EXPECT_TRUE(board_.take(edit(0, 1, 4)));  // of the map before
  EXPECT_TRUE(board_.edits().empty());
}

TEST_F(Board, RefusesWhatNoSlamdSends) {
  const auto refused = [&](auto&& change) {
    map_edit_t message = edit(0, 1);
    change(message);
    return !board_.take(message);
  };
  EXPECT_TRUE(refused([](map_edit_t& m) { m.edits = -1; }));
  EXPECT_TRUE(refused([](map_edit_t& m) { m.edits = 2'000'000'000; }));
  EXPECT_TRUE(refused([](map_edit_t& m) { m.index = 1; }));
  EXPECT_TRUE(refused([](map_edit_t& m) { m.index = -1; }));
  EXPECT_TRUE(refused([](map_edit_t& m) { m.kind = "hole"; }));
  EXPECT_TRUE(refused([](map_edit_t& m) { m.x[0] = std::nan(""); }));
  EXPECT_TRUE(refused([](map_edit_t& m) { m.theta = std::numeric_limits<double>::infinity(); }));
  EXPECT_TRUE(refused([](map_edit_t& m) { m.name.assign(kEditLimits.name_bytes + 1, 'a'); }));
  EXPECT_TRUE(refused([](map_edit_t& m) { m.npoints = 0, m.x = m.y = {}; }));
  EXPECT_TRUE(board_.edits().empty());
}

TEST_F(Board, IsBoundedAsJson) {
  const int count = 30;
  for (int i = 0; i < count; ++i) {
    map_edit_t large = edit(i, count);
    large.npoints = 1000;
    large.x.assign(1000, 0.5), large.y.assign(1000, -0.25);
    EXPECT_TRUE(board_.take(large));
  }
  EXPECT_EQ(board_.edits().size(), 30U);
  const auto list = editsJson(board_);
  EXPECT_EQ(list.size(), EditBoard::kMostPoints / 1000);
  EXPECT_EQ(list[0]["points"][0], nlohmann::json({0.5, -0.25}));
}

}  // namespace
}  // namespace slam::edit_board_test
