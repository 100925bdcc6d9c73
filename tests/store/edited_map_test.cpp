// SPDX-License-Identifier: BSD-3-Clause
// The edits of a map in its store: what is written with which durability. The store's own tests are map_store_test.cpp.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "store/map_manifest.hpp"
#include "store/map_store.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::edited_map_test {
namespace {

namespace fs = std::filesystem;
using test::contentOf;
using test::differenceOf;
using test::Folder;
using testing::HasSubstr;
using testing::IsEmpty;
const OccupancyGridConfig kGrid = test::smallGrid();

/// A map that is edited in two generations, each with a journal, as it was at each writing.
class EditedDrive {
 public:
  explicit EditedDrive(const fs::path& directory) : store(directory, "home") {
    checkpoint();
    edit(EditKind::kErase, 1.0, 0.5);
    append();
    changing.move();
    append();
    edit(EditKind::kFree, 1.5, 0.0);
    checkpoint();
    changing.addKeyframe(true);
    append();
    edit(EditKind::kRoom, 0.0, 0.0);
    append();
    EXPECT_EQ(test::edit(changing.map, {.kind = EditCommand::kUndo, .request = {}, .id = 0, .utime = 0}), "");
    changing.move();
    append();
  }
  void edit(EditKind kind, double x, double y) {
    EXPECT_EQ(test::edit(changing.map, test::squareEdit(kind, x, y)), "");
  }
  void checkpoint() {
    changing.map.grid = test::drawn(changing.map);
    changing.map.grid_keyframes = changing.map.keyframes.size();
    store.checkpoint(changing.map);
    states.push_back(changing.copy());
  }
  void append() {
    store.append(changing.map);
    store.sync();
    states.push_back(changing.copy());
  }
  int find(const MapState& map) const {
    for (std::size_t i = states.size(); i-- > 0;) {
      if (differenceOf(map, states[i]).empty()) return static_cast<int>(i);
    }
    return -1;
  }

  MapStore store;
  test::ChangingMap changing;
  std::vector<MapState> states;
};
constexpr int kSecond = 3, kLast = 6;  // states: of generation 2, of all

void expectGridOf(const LoadedMap& loaded) {
  Mapper mapper(kGrid);
  mapper.load(scansOf(loaded.state), viewsOf(loaded.state), loaded.state.grid.clone(), loaded.state.grid_keyframes,
              drawingOf(loaded.state));
  EXPECT_TRUE(test::sameCells(mapper.grid(), test::drawn(loaded.state)));
}

TEST(EditedMap, LoadsItsEditsAndTheGridThatTheyAskFor) {
  const Folder folder;
  const EditedDrive drive(folder / "");
  const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
  EXPECT_EQ(drive.find(loaded.state), kLast) << differenceOf(loaded.state, drive.states.back());
  EXPECT_THAT(loaded.remarks, IsEmpty());
  EXPECT_FALSE(loaded.state.edits.whole.empty());
  expectGridOf(loaded);
}

TEST(EditedMap, LosesNothingByAFlippedByteInTheNewestGeneration) {
  const Folder folder;
  const EditedDrive drive(folder / "");
  for (const char* name : {"edits.bin", "keyframes.bin", "MANIFEST"}) {
    const fs::path file = folder / "home/000002" / name;
    const std::string whole = contentOf(file);
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ '\x08');
      std::ofstream(file, std::ios::binary) << damaged;
      const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
      ASSERT_EQ(drive.find(loaded.state), kLast) << name << " " << at;
      ASSERT_EQ(loaded.generation, 1);
    }
    std::ofstream(file, std::ios::binary) << whole;
  }
}

TEST(EditedMap, IsOneOfItsStatesWhereverItsJournalIsCut) {
  const Folder folder;
  const EditedDrive drive(folder / "");
  const fs::path file = folder / "home/000002.journal";
  const std::string whole = contentOf(file);
  int least = kLast;
  for (std::size_t size = whole.size() + 1; size-- > 0;) {
    fs::resize_file(file, size);
    const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
    const int state = drive.find(loaded.state);
    ASSERT_GE(state, kSecond) << size;
    ASSERT_LE(state, least) << size;
    least = state;
    if (size % 64 == 0) expectGridOf(loaded);
  }
  EXPECT_EQ(least, kSecond);
}

TEST(EditedMap, IsOfANewerFormatOnlyWithEdits) {
  const Folder folder;
  const EditedDrive drive(folder / "");
  EXPECT_THAT(contentOf(folder / "home/000001/MANIFEST"), HasSubstr("version 1\n"));
  EXPECT_THAT(contentOf(folder / "home/000002/MANIFEST"), HasSubstr("version 2\n"));
  EXPECT_FALSE(fs::exists(folder / "home/000001/edits.bin"));
}

TEST(EditedMap, StoresWholeScansSoThatAnEraseCanBeUndoneAnotherDay) {
  const Folder folder;
  test::ChangingMap changing(5);
  const MapState before = changing.copy();
  MapStore store(folder / "", "home");
  ASSERT_EQ(test::edit(changing.map, test::squareEdit(EditKind::kErase, 1.0, 0.5)), "");
  ASSERT_FALSE(changing.map.edits.whole.empty());
  store.checkpoint(changing.map);
  MapState loaded = MapStore::load(folder / "", "home", kGrid).state;
  ASSERT_EQ(test::edit(loaded, {.kind = EditCommand::kUndo, .request = {}, .id = 0, .utime = 0}), "");
  loaded.edits = before.edits;
  EXPECT_EQ(differenceOf(loaded, before), "");
}

}  // namespace
}  // namespace slam::edited_map_test
