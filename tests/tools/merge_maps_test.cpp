// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/maps/merge_maps.hpp"

#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>

#include "problems/answer.hpp"
#include "problems/answers.hpp"
#include "store/durable_file.hpp"
#include "store/map_store.hpp"
#include "support/simulated/mapped_drive.hpp"
#include "tools/files.hpp"

namespace slam::merge_maps_test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

/// A folder of two maps of one corridor, one of two twin rooms, and one of a single twin.
struct StoredMaps : testing::Test {
  StoredMaps() {
    store("a", test::mapped(test::ringCorridor(), test::alongRing(0.0, 24.0), 1).map);
    store("b", test::mapped(test::ringCorridor(), test::alongRing(14.0, 38.0), 2).map);
  }
  void store(const char* name, const MapState& map) const { MapStore(folder / "", name).checkpoint(map); }
  StoredMerge merge(const char* first, const char* second, const char* merged = "c") const {
    return {.directory = folder / "", .first = first, .second = second, .merged = merged, .grid = test::smallGrid()};
  }
  std::string refusal(const StoredMerge& merge) const {
    return test::refusalOf([&] { merge.carryOut(); });
  }
  /// The bytes of all files of a map, by name.
  std::map<std::string, std::string> bytesOf(const char* name) const {
    std::map<std::string, std::string> bytes;
    for (const auto& entry : fs::recursive_directory_iterator(folder / name)) {
      if (entry.is_regular_file()) bytes[entry.path().string()] = test::contentOf(entry.path());
    }
    return bytes;
  }

  test::Folder folder;
};

TEST_F(StoredMaps, AreMergedAndStay) {
  const auto a = bytesOf("a"), b = bytesOf("b");
  const std::string done = merge("a", "b").carryOut();
  EXPECT_THAT(done, HasSubstr("map c: 97 keyframes of a and 97 of b"));
  EXPECT_THAT(done, HasSubstr("overlap"));
  EXPECT_THAT(done, HasSubstr("residual"));
  EXPECT_EQ(MapStore::load(folder / "", "c", test::smallGrid()).state.keyframes.size(), 194);
  EXPECT_EQ(MapStore::newest(folder / ""), "b") << "a start continues what it would have";
  EXPECT_EQ(bytesOf("a"), a);
  EXPECT_EQ(bytesOf("b"), b);
}

TEST_F(StoredMaps, AreRefusedByTheirNames) {
  EXPECT_THAT(refusal(merge("a", "a")), HasSubstr("itself"));
  EXPECT_THAT(refusal(merge("a", "x")), HasSubstr("no map \"x\""));
  EXPECT_THAT(refusal(merge("a", "../a")), HasSubstr("no name"));
  EXPECT_THAT(refusal(merge("a", "b", "../c")), HasSubstr("no name"));
  EXPECT_THAT(refusal(merge("a", "b", "b")), HasSubstr("already"));
}

TEST_F(StoredMaps, AreRefusedWhereTheSecondOneIsDamaged) {
  std::ofstream(folder / "b" / "000001" / "keyframes.bin", std::ios::binary) << "torn";
  EXPECT_THAT(refusal(merge("a", "b")), HasSubstr("keyframes.bin"));
  EXPECT_FALSE(fs::exists(folder / "c"));
}

TEST_F(StoredMaps, OfTwinRoomsAreRefusedWithBothPlacesAndTheirPictures) {
  store("twins", test::mapped(test::twins(), test::inTwins(), 1).map);
  store("one", test::mapped(test::twins(), test::alongX(-1.6, 2.0, 0.1), 2).map);
  StoredMerge twins = merge("twins", "one");
  EXPECT_THAT(refusal(twins), HasSubstr("two places of twins fit one"));
  twins.pictures = folder / "pictures";
  EXPECT_THAT(refusal(twins), HasSubstr("pictures-1.png"));
  EXPECT_TRUE(fs::exists(folder / "pictures-1.png"));
  EXPECT_TRUE(fs::exists(folder / "pictures-2.png"));
  EXPECT_FALSE(fs::exists(folder / "c"));
}

TEST_F(StoredMaps, WithoutCommonGroundAreRefused) {
  store("room", test::mapped(test::furnishedRoom(), test::alongX(-1.5, 1.5, 0.1), 3).map);
  EXPECT_THAT(refusal(merge("a", "room")), HasSubstr("was not found in a"));
  EXPECT_FALSE(fs::exists(folder / "c"));
}

TEST_F(StoredMaps, OfTwoFloorsNeedTheFlagForMovedFurniture) {
  store("ground", test::home(1, 1).map);
  store("upper", test::home(1, 2, 0, 2).map);
  StoredMerge floors = merge("ground", "upper");
  try {
    floors.carryOut();
    ADD_FAILURE() << "two floors are one map";
  } catch (const CommandRefused& refused) {
    EXPECT_TRUE(refused.why().is(answer::kOtherFurniture)) << refused.what();
    EXPECT_THAT(refused.why().texts(), testing::ElementsAre("ground", "upper"));
    EXPECT_THAT(refused.what(), HasSubstr("another floor that looks alike, or a home whose furniture was moved far"));
    EXPECT_THAT(refused.what(), HasSubstr("--moved"));
  }
  EXPECT_FALSE(fs::exists(folder / "c"));
  floors.furniture_moved = true;
  EXPECT_THAT(floors.carryOut(), HasSubstr("map c"));
  EXPECT_TRUE(fs::exists(folder / "c"));
}

TEST_F(StoredMaps, AreMergedWhileAnotherProgramHasThemOpen) {
  const FolderLock slamd(folder / "a");
  EXPECT_THAT(merge("a", "b").carryOut(), HasSubstr("map c"));
}

}  // namespace
}  // namespace slam::merge_maps_test
