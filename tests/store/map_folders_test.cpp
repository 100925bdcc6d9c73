// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_folders.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "store/durable_file.hpp"
#include "store/map_store.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::map_folders_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class MapFolders : public testing::Test {
 protected:
  MapFolders() {
    for (const char* name : {"a", "b", "c"}) MapStore(directory, name).checkpoint(test::ChangingMap(4).map);
  }
  std::vector<std::string> names() const {
    std::vector<std::string> found;
    for (const MapSummary& map : MapStore::list(directory)) found.push_back(map.name);
    return found;
  }
  const test::Folder folder;
  const std::filesystem::path directory = folder / "";
};

TEST_F(MapFolders, BringBackTheMapThatWasPutAsideLast) {
  putMapAside(directory, "a");
  EXPECT_THAT(names(), ElementsAre("b", "c"));
  EXPECT_EQ(MapStore::newest(directory), "c");
  EXPECT_EQ(restoreMap(directory), "a");
  EXPECT_THAT(names(), ElementsAre("a", "b", "c"));
  EXPECT_EQ(MapStore::load(directory, "a", test::smallGrid()).state.keyframes.size(), 4);
  EXPECT_THAT(test::refusalOf([&] { restoreMap(directory); }), HasSubstr("no deleted map"));
}

TEST_F(MapFolders, KeepOneMapAsideAndNoMore) {
  putMapAside(directory, "a");
  putMapAside(directory, "b");
  EXPECT_EQ(restoreMap(directory), "b");
  EXPECT_THAT(test::refusalOf([&] { restoreMap(directory); }), HasSubstr("no deleted map"));
  EXPECT_THAT(names(), ElementsAre("b", "c"));
  putMapAside(directory, "b");
  renameMap(directory, "c", "b");
  putMapAside(directory, "b");  // another one of that name
  EXPECT_EQ(restoreMap(directory), "b");
  EXPECT_THAT(test::refusalOf([&] { restoreMap(directory); }), HasSubstr("no deleted map"));
  EXPECT_THAT(names(), ElementsAre("b"));
}

TEST_F(MapFolders, BringNoMapBackOverAnother) {
  putMapAside(directory, "a");
  renameMap(directory, "b", "a");
  EXPECT_THAT(test::refusalOf([&] { restoreMap(directory); }), HasSubstr("already"));
  renameMap(directory, "a", "b");
  EXPECT_EQ(restoreMap(directory), "a");
}

TEST_F(MapFolders, LeaveMapsAloneThatAProgramWrites) {
  const FolderLock slamd(directory / "a");
  EXPECT_THROW(putMapAside(directory, "a"), FolderLocked);
  EXPECT_THROW(removeMap(directory, "a"), FolderLocked);
  EXPECT_THROW(renameMap(directory, "a", "d"), FolderLocked);
  EXPECT_THAT(names(), ElementsAre("a", "b", "c"));
}

TEST_F(MapFolders, RefuseNamesThatArePathsOrTakenOrOfNoMap) {
  for (const char* name : {"..", ".", "", "../a", "a/000001", ".deleted", "d"}) {
    EXPECT_NE(test::refusalOf([&] { putMapAside(directory, name); }), "") << name;
    EXPECT_NE(test::refusalOf([&] { removeMap(directory, name); }), "") << name;
    EXPECT_NE(test::refusalOf([&] { renameMap(directory, name, "e"); }), "") << name;
  }
  for (const char* name : {"..", "", "b", "a b", "x/y", ".deleted", "floor.yaml"})
    EXPECT_NE(test::refusalOf([&] { renameMap(directory, "a", name); }), "") << name;
  EXPECT_THAT(names(), ElementsAre("a", "b", "c"));
  removeMap(directory, "a");
  EXPECT_THAT(names(), ElementsAre("b", "c"));
}

}  // namespace
}  // namespace slam::map_folders_test
