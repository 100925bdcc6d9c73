// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/maps/stored_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slam/edits/edit_json.hpp"
#include "store/durable_file.hpp"
#include "store/map_store.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::stored_map_test {
namespace {

using testing::HasSubstr;
using testing::SizeIs;
namespace fs = std::filesystem;

/// A folder of two maps, of which b is the one that a start continues.
struct Maps : testing::Test {
  Maps() {
    for (const char* name : {"a", "b"}) MapStore(folder / "", name).checkpoint(test::ChangingMap(6).map);
  }
  StoredMap map(const char* name) const { return {folder / "", name, test::smallGrid()}; }
  MapState load(const char* name) const { return MapStore::load(folder / "", name, test::smallGrid()).state; }
  static EditCommand adding(const char* json) {
    return {.kind = EditCommand::kAdd, .request = editRequestOf(json), .id = 0, .utime = 1};
  }

  test::Folder folder;
  const EditCommand zone = adding(R"({"kind": "zone", "points": [[0, 0], [1, 0], [1, 1]], "by": "me"})");
  const EditCommand crossed = adding(R"({"kind": "free", "points": [[0, 0], [1, 1], [1, 0], [0, 1]], "by": "me"})");
};

TEST_F(Maps, KeepTheEditsOfAFileAndTheOneThatIsContinued) {
  EXPECT_EQ(map("a").edit(std::vector{zone, zone}), "2 edits of map a");
  EXPECT_THAT(load("a").edits.edits, SizeIs(2));
  EXPECT_TRUE(load("b").edits.empty());
  EXPECT_EQ(MapStore::newest(folder / ""), "b");
  map("b").edit(std::vector{zone});
  EXPECT_EQ(MapStore::newest(folder / ""), "b");
  const EditCommand undo{.kind = EditCommand::kUndo, .request = {}, .id = 0, .utime = 2};
  map("a").edit(std::vector{undo});
  const MapState undone = load("a");
  EXPECT_EQ(std::ranges::count(undone.edits.edits, true, &MapEdit::active), 1);
}

TEST_F(Maps, AreLeftAsTheyWereByAFileWithOneBadEdit) {
  EXPECT_THAT(test::refusalOf([&] { map("a").edit(std::vector{zone, crossed}); }), HasSubstr("edit 2 of 2"));
  EXPECT_TRUE(load("a").edits.empty());
}

TEST_F(Maps, LoseNoReferenceByAnEraseUnlessItIsForced) {
  EditCommand all = adding(R"({"kind": "erase", "points": [[-9, -9], [9, -9], [9, 9], [-9, 9]], "by": "me"})");
  EXPECT_THAT(test::refusalOf([&] { map("a").edit(std::vector{all}); }), HasSubstr("force"));
  all.request.force = true;
  map("a").edit(std::vector{all});
  const MapState erased = load("a");
  for (int id = 0; id < erased.keyframes.size(); ++id) EXPECT_TRUE(erased.keyframes.scan(id)->points.empty());
}

TEST_F(Maps, ThatASlamdHasOpenAreNotTouched) {
  const FolderLock slamd(folder / "a");
  EXPECT_THROW(map("a").edit(std::vector{zone}), FolderLocked);
  EXPECT_THROW(map("a").remove(), FolderLocked);
  EXPECT_THROW(map("a").rename("c"), FolderLocked);
  EXPECT_TRUE(load("a").edits.empty());
}

TEST_F(Maps, AreRenamedAndRemoved) {
  EXPECT_THAT(test::refusalOf([&] { map("a").rename("b"); }), HasSubstr("already"));
  EXPECT_THAT(test::refusalOf([&] { map("a").rename("../c"); }), HasSubstr("no name"));
  map("a").rename("c");
  EXPECT_EQ(load("c").keyframes.size(), 6);
  map("c").remove();
  EXPECT_FALSE(fs::exists(folder / "c"));
  EXPECT_THAT(test::refusalOf([&] { map("c").remove(); }), HasSubstr("no map"));
  EXPECT_THAT(test::refusalOf([&] { map("..").edit(std::vector{zone}); }), HasSubstr("no name"));
}

TEST(EditsIn, TakesAListOrOneAndNamesItsAuthor) {
  const auto edits = editsIn(R"([{"kind": "zone"}, {"kind": "wall", "by": "planner"}])", "me");
  ASSERT_THAT(edits, SizeIs(2));
  EXPECT_EQ(editRequestOf(edits[0]).author, "me");
  EXPECT_EQ(editRequestOf(edits[1]).author, "planner");
  EXPECT_THAT(editsIn(R"({"kind": "zone"})", "me"), SizeIs(1));
  for (const char* bad : {"", "[]", "3", "[{", "\"zone\""})
    EXPECT_THAT(test::refusalOf([&] { editsIn(bad, "me"); }), HasSubstr("no JSON list")) << bad;
}

}  // namespace
}  // namespace slam::stored_map_test
