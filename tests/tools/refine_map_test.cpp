// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/maps/refine_map.hpp"

#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "store/durable_file.hpp"
#include "store/map_store.hpp"
#include "support/simulated/mapped_drive.hpp"
#include "tools/common/refinement_words.hpp"
#include "tools/files.hpp"
#include "tools/slamctl/maps/stored_map.hpp"

namespace slam {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

struct StoredLaps : testing::Test {
  StoredLaps() {
    MapStore(folder / "", "a").checkpoint(test::mapped(test::ringCorridor(), test::alongRing(0.0, 90.0), 1).map);
  }
  StoredRefinement refinement(const char* name, const char* refined = "") const {
    return {.directory = folder / "", .name = name, .refined = refined, .grid = test::smallGrid()};
  }
  std::string refusal(const StoredRefinement& refinement) const {
    return test::refusalOf([&] { refinement.carryOut({}); });
  }
  LoadedMap load(const char* name) const { return MapStore::load(folder / "", name, test::smallGrid()); }

  test::Folder folder;
};

TEST_F(StoredLaps, AreReplacedByANewGenerationBesideTheOldOne) {
  std::string announced;
  const std::string done = refinement("a").carryOut([&](const std::string& words) { announced = words; });
  EXPECT_THAT(announced, HasSubstr("MB of memory"));
  EXPECT_THAT(done, HasSubstr("closures held back"));
  EXPECT_THAT(done, HasSubstr("map a is refined"));
  EXPECT_EQ(load("a").generation, 2);
  EXPECT_TRUE(fs::exists(folder / "a" / "000001"));
}

TEST_F(StoredLaps, StayWhereTheResultHasANameOfItsOwn) {
  EXPECT_THAT(refinement("a", "b").carryOut({}), HasSubstr("stored as b"));
  EXPECT_EQ(load("a").generation, 1);
  EXPECT_EQ(load("b").state.keyframes.size(), load("a").state.keyframes.size());
  EXPECT_EQ(MapStore::newest(folder / ""), "a") << "a start continues what it would have";
}

TEST_F(StoredLaps, AreNotTouchedWhileSlamdHasThemOpen) {
  const FolderLock slamd(folder / "a");
  EXPECT_THAT(refusal(refinement("a")), HasSubstr("slamd has map a open"));
  EXPECT_EQ(load("a").generation, 1);
  EXPECT_THAT(refinement("a", "b").carryOut({}), HasSubstr("stored as b"));
}

TEST_F(StoredLaps, AreRefusedByTheirNamesAndWhereDamaged) {
  EXPECT_THAT(refusal(refinement("x")), HasSubstr("no map \"x\""));
  EXPECT_THAT(refusal(refinement("../a")), HasSubstr("no name"));
  EXPECT_THAT(refusal(refinement("a", "a")), HasSubstr("already"));
  std::ofstream(folder / "a" / "000001" / "graph.bin", std::ios::binary) << "damaged";
  EXPECT_NE(refusal(refinement("a")), "");
}

TEST_F(StoredLaps, StayWhereThereIsNothingToRefine) {
  MapStore(folder / "", "one").checkpoint(test::mapped(test::ringCorridor(), test::alongRing(0.0, 0.0), 1).map);
  EXPECT_THAT(refinement("one", "two").carryOut({}), HasSubstr("kept as it was"));
  EXPECT_FALSE(fs::exists(folder / "two"));
}

TEST_F(StoredLaps, AreNotReplacedWhenTheyWereChangedMeanwhile) {
  const StoredMap map{folder / "", "a", test::smallGrid()};
  const LoadedMap before = load("a");
  map.straighten("");
  EXPECT_THAT(test::refusalOf([&] { map.replaceBy(before, before.state); }), HasSubstr("changed meanwhile"));
}

TEST(RefinementWords, NameTheFiguresAndWhyAMapIsKept) {
  RefineReport report{
      .outcome = RefineReport::Outcome::kNoBetter, .before = {0.01, 0.02, 0.03}, .after = {0.011, 0.02, 0.03}};
  EXPECT_THAT(wordsOf(report, "a"), HasSubstr("11.0 mm"));
  EXPECT_THAT(wordsOf(report, "a"), HasSubstr("map a is kept as it was: the figures do not fall"));
}

}  // namespace
}  // namespace slam
