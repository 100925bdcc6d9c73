// SPDX-License-Identifier: BSD-3-Clause
#include "app/map/map_keeper.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "mapping/map_files.hpp"
#include "support/file_size_limit.hpp"
#include "support/irremovable.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::map_keeper_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::ChangingMap;
using test::contentOf;
using test::refusalOf;
using testing::AllOf;
using testing::HasSubstr;

constexpr Timestamp kNow{10s};

class MapKeeping : public testing::Test {
 protected:
  MapKeeping() {
    fs::create_directories(folder / "maps");
    config.store.directory = folder / "maps";
    config.map = test::smallGrid();
    config.front_end.lidar.T_base_lidar = ChangingMap().map.T_base_lidar;
  }
  /// A stored map that was written so long ago, by a slamd that counted no order.
  void store(const std::string& name, std::chrono::hours age, int keyframes) {
    MapStore(folder / "maps", name).writeCopy(ChangingMap(keyframes).map);
    for (const auto& entry : fs::directory_iterator(folder / "maps" / name)) {
      fs::last_write_time(entry.path(), fs::file_time_type::clock::now() - age);
    }
  }
  void damage(const std::string& name) const {
    std::ofstream(folder / "maps" / name / "000001/keyframes.bin") << "nonsense";
    fs::last_write_time(folder / "maps" / name / "000001", fs::file_time_type::clock::now());
  }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder / "maps")) all.push_back(entry.path().filename());
    std::sort(all.begin(), all.end());
    return all;
  }
  /// What begin() says instead of giving a map: one line.
  std::string refusal() const {
    MapKeeper keeper(config);
    EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 0);
    const std::string text = keeper.problem().words();
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text;
  }
  int newestKeyframes(const std::string& name) const {
    return MapStore::load(folder / "maps", name, config.map).state.keyframes.size();
  }

  const test::Folder folder;
  Config config;
};

TEST_F(MapKeeping, GivesTheOtherFloorsWithAMap) {
  store("ground", 3h, 3);
  store("first", 1h, 5);
  EXPECT_TRUE(MapKeeper(config).begin(kNow).floors.others.empty()) << "unless they are asked for";
  config.store.floors = "*";
  MapKeeper keeper(config);
  const MapState map = keeper.begin(kNow);
  EXPECT_EQ(map.floors.present, "first");
  ASSERT_EQ(map.floors.others.size(), 1U);
  EXPECT_EQ(map.floors.others[0]->name, "ground");
  EXPECT_EQ(keeper.load("ground", kNow).floors.others.at(0)->name, "first");
}

TEST_F(MapKeeping, BeginsInTheNewestMap) {
  store("old", 3h, 3);
  store("new", 1h, 5);
  store("middle", 2h, 4);
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 5);
  EXPECT_EQ(keeper.name(), "new");
  EXPECT_TRUE(keeper.writes());
}

TEST_F(MapKeeping, GoesOnInTheMapOfTheLastRunWhateverTheClocksRead) {
  std::string last;
  {
    MapKeeper keeper(config);
    keeper.begin(kNow);
    ASSERT_TRUE(keeper.checkpoint(kNow, ChangingMap(3).map));
    for (const auto& entry : fs::directory_iterator(folder / "maps" / keeper.name())) {
      fs::last_write_time(entry.path(), fs::file_time_type::clock::now() + 24h * 3650);  // a clock ten years ahead
    }
    keeper.beginNew(kNow + 1s);
    ASSERT_TRUE(keeper.checkpoint(kNow + 1s, ChangingMap(6).map));
    last = keeper.name();
  }
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 6);
  EXPECT_EQ(keeper.name(), last);
}

TEST_F(MapKeeping, WhatLiesBesideAGoodMapBeginsNoNewOne) {
  store("home", 1h, 5);
  const fs::path maps = folder / "maps";
  const std::function<void()> kStrange[] = {
      [&] { fs::create_directories(maps / "map-2/000001"); },
      [&] { fs::create_directories(maps / "home/000001.journal/in the way"); },
      [&] { fs::create_symlink("loop", maps / "loop"); },
      [&] { fs::create_symlink("000002", maps / "home/000002"); },
      [&] { fs::create_directories(maps / "home/999999999"); },
  };
  for (const auto& put : kStrange) {
    fs::remove_all(maps / "home/000001.journal");
    put();
    MapKeeper keeper(config);
    EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 5);
    EXPECT_EQ(keeper.name(), "home");
    EXPECT_EQ(keeper.problem().words(), "");
  }
  MapKeeper keeper(config);
  keeper.begin(kNow);
  ASSERT_TRUE(keeper.checkpoint(kNow, ChangingMap(7).map)) << keeper.problem().words();
  EXPECT_EQ(newestKeyframes("home"), 7);
}

TEST_F(MapKeeping, StoresTheMapThoughAnOlderGenerationCannotBeRemoved) {
  store("home", 1h, 5);
  const test::Irremovable stays(folder / "maps/home/000001/keyframes.bin");
  if (!stays.holds()) GTEST_SKIP() << "root may remove any file of this file system";
  MapKeeper keeper(config);
  keeper.begin(kNow);
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(keeper.checkpoint(kNow, ChangingMap(6 + i).map));
    EXPECT_EQ(keeper.problem().words(), "");
    EXPECT_EQ(keeper.stored(), 6 + i);
    EXPECT_TRUE(keeper.hasJournal());
  }
  EXPECT_EQ(newestKeyframes("home"), 9);
}

TEST_F(MapKeeping, StoresNoMapThatItCouldNotReadAgain) {
  MapKeeper keeper(config);
  keeper.begin(kNow);
  ASSERT_TRUE(keeper.checkpoint(kNow, ChangingMap(5).map));
  ChangingMap far(6);
  far.map.T_map_base.x = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(keeper.journal(kNow + 1s, far.map));
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(keeper.checkpoint(kNow + 60s, far.map));
    EXPECT_THAT(keeper.problem().words(),
                testing::MatchesRegex("not written since .*the map is not stored, 1 of 6 "
                                      "keyframes are in memory alone, slamd tries again; .*slamctl reset.*"));
  }
  EXPECT_EQ(newestKeyframes(keeper.name()), 5);
}

TEST_F(MapKeeping, BeginsInTheMapThatIsConfigured) {
  store("old", 3h, 3);
  store("new", 1h, 5);
  config.store.map = "old";
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 3);
  EXPECT_EQ(keeper.name(), "old");
  config.store.map = "kitchen";  // a name for a new one
  MapKeeper other(config);
  EXPECT_EQ(other.begin(kNow).keyframes.size(), 0);
  EXPECT_EQ(other.name(), "kitchen");
}

TEST_F(MapKeeping, BeginsANewMapWhereThereIsNone) {
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 0);
  EXPECT_THAT(keeper.name(), testing::MatchesRegex("map-[0-9]+-[0-9]+"));
  config.store.directory.clear();
  MapKeeper nowhere(config);
  EXPECT_EQ(nowhere.begin(kNow).keyframes.size(), 0);
  EXPECT_FALSE(nowhere.writes());
  EXPECT_FALSE(nowhere.mayWrite(Timestamp(1h)));
}

TEST_F(MapKeeping, ReadsOnlyWhereItLocalises) {
  store("home", 1h, 5);
  config.mode = RunMode::kLocalise;
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 5);
  EXPECT_FALSE(keeper.writes());
  EXPECT_FALSE(keeper.mayWrite(Timestamp(1h)));
  EXPECT_FALSE(keeper.checkpoint(Timestamp(1h), ChangingMap().map));
  EXPECT_EQ(newestKeyframes("home"), 5);
}

TEST_F(MapKeeping, ChangesTheMode) {
  store("home", 1h, 5);
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 5);
  EXPECT_EQ(keeper.changeMode(true, kNow).keyframes.size(), 5);
  EXPECT_TRUE(keeper.localises());
  EXPECT_FALSE(keeper.writes());
  EXPECT_FALSE(keeper.checkpoint(Timestamp(1h), ChangingMap().map));
  EXPECT_EQ(MapKeeper(config).begin(kNow).keyframes.size(), 5) << "who else extends it may";
  EXPECT_EQ(keeper.changeMode(false, kNow).keyframes.size(), 5);
  EXPECT_TRUE(keeper.checkpoint(Timestamp(1h), ChangingMap(7).map));
  EXPECT_EQ(newestKeyframes("home"), 7);
}

TEST_F(MapKeeping, KeepsTheModeWhereTheOtherHasNoMap) {
  MapKeeper keeper(config);
  keeper.begin(kNow);
  EXPECT_THROW(keeper.changeMode(true, kNow), std::runtime_error);
  EXPECT_FALSE(keeper.localises());
  EXPECT_TRUE(keeper.checkpoint(Timestamp(1h), ChangingMap(3).map)) << keeper.problem().words();

  config.mode = RunMode::kLocalise;
  config.store.directory = folder / "none";
  MapKeeper waiting(config);
  waiting.begin(kNow);
  EXPECT_EQ(waiting.changeMode(false, kNow).keyframes.size(), 0);
  EXPECT_TRUE(waiting.writes());
  EXPECT_EQ(waiting.problem().words(), "");

  config.store.map = "plan.yaml";
  MapKeeper plan(config);
  EXPECT_THROW(plan.changeMode(false, kNow), std::runtime_error);
  EXPECT_TRUE(plan.localises());
}

TEST_F(MapKeeping, CallsWrongWhatNoDiskCanHeal) {
  EXPECT_EQ(MapKeeper::misconfiguration(Config{}), "");
  EXPECT_EQ(MapKeeper::misconfiguration(config), "");
  config.store.map = "../home";
  EXPECT_THAT(MapKeeper::misconfiguration(config), HasSubstr("store.map: is no name of a map"));
  config.store.map = "picture.yaml";
  EXPECT_THAT(MapKeeper::misconfiguration(config), HasSubstr("set mode to \"localise\""));
  config.mode = RunMode::kLocalise;
  EXPECT_EQ(MapKeeper::misconfiguration(config), "");
  config.store.map = "home";
  EXPECT_EQ(MapKeeper::misconfiguration(config), "") << "it may still come";
  config.store.directory.clear();
  EXPECT_THAT(MapKeeper::misconfiguration(config), AllOf(HasSubstr("needs a map"), HasSubstr("store.map")));
}

TEST_F(MapKeeping, WaitsForAMapToLocaliseIn) {
  config.mode = RunMode::kLocalise;
  EXPECT_THAT(refusal(),
              AllOf(HasSubstr("no map to localise in: there is none in the folder"), HasSubstr("store.map")));
  config.store.map = "kitchen";
  EXPECT_THAT(refusal(), HasSubstr("kitchen: there is no such map"));
  config.store.map = folder / "missing.yaml";
  EXPECT_THAT(refusal(), HasSubstr("missing.yaml: there is no such map"));

  config.store.map.clear();
  MapKeeper keeper(config);
  keeper.begin(kNow);
  EXPECT_FALSE(keeper.retryDue(kNow + 900ms));
  ASSERT_TRUE(keeper.retryDue(kNow + 1s));
  EXPECT_FALSE(keeper.retry(kNow + 1s));
  EXPECT_FALSE(keeper.retryDue(kNow + 2s)) << "less and less often";
  store("home", 1h, 5);
  ASSERT_TRUE(keeper.retryDue(kNow + 3s));
  const auto found = keeper.retry(kNow + 3s);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->keyframes.size(), 5);
  EXPECT_EQ(keeper.problem().words(), "");
  EXPECT_FALSE(keeper.retryDue(kNow + 1000s));
  EXPECT_FALSE(keeper.checkpoint(kNow + 4s, *found));
}

TEST_F(MapKeeping, UsesNoMapOfAnotherLidar) {
  store("home", 1h, 5);
  config.store.map = "home";
  config.front_end.lidar.T_base_lidar.x += 0.1;
  EXPECT_THAT(refusal(), AllOf(HasSubstr("was made with the lidar at"), HasSubstr("fix [lidar]")));
  config.mode = RunMode::kLocalise;
  EXPECT_THAT(refusal(), HasSubstr("was made with the lidar at"));
}

TEST_F(MapKeeping, ExtendsNoPicture) {
  writeMapFiles(folder / "picture", renderMap(ChangingMap().map.grid), {});
  config.store.map = folder / "picture.yaml";
  EXPECT_THAT(refusal(), HasSubstr("a picture of a map cannot be extended"));
  config.mode = RunMode::kLocalise;
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin(kNow).kind, MapKind::kFloorPlan);
  EXPECT_FALSE(keeper.writes());
}

TEST_F(MapKeeping, LeavesADamagedNewestMapAndBeginsANewOne) {
  store("home", 1h, 5);
  damage("home");
  const std::string before = contentOf(folder / "maps/home/000001/keyframes.bin");
  {
    MapKeeper keeper(config);
    EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 0);
    EXPECT_NE(keeper.name(), "home");
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(keeper.checkpoint(Timestamp(1h), ChangingMap(3 + i).map));
    EXPECT_EQ(names().size(), 2U);
  }
  EXPECT_EQ(contentOf(folder / "maps/home/000001/keyframes.bin"), before);
  EXPECT_FALSE(fs::exists(folder / "maps/home/000002"));
  config.store.map = "home";  // asked for by name it is not silently replaced
  EXPECT_THAT(refusal(), AllOf(HasSubstr("keyframes.bin: is damaged"), HasSubstr("a new map that is not stored")));
  MapKeeper keeper(config);
  keeper.begin(kNow);
  EXPECT_FALSE(keeper.checkpoint(kNow, ChangingMap().map)) << "that would bury it";
  EXPECT_EQ(contentOf(folder / "maps/home/000001/keyframes.bin"), before);
  for (Timestamp now = kNow; now < kNow + 100s; now += 1s) {
    if (!keeper.retryDue(now)) continue;
    EXPECT_FALSE(keeper.retry(now));
  }
  EXPECT_NE(keeper.problem().words(), "");
  fs::remove_all(folder / "maps/home");
  store("home", 1h, 7);  // from a backup
  const auto healed = keeper.retry(kNow + 200s);
  ASSERT_TRUE(healed);
  EXPECT_EQ(healed->keyframes.size(), 7);
  EXPECT_EQ(keeper.problem().words(), "");
  EXPECT_TRUE(keeper.checkpoint(kNow + 201s, ChangingMap(8).map));
  EXPECT_EQ(newestKeyframes("home"), 8);
}

TEST_F(MapKeeping, ExtendsAMapOnADiskThatCannotBeWritten) {
  store("home", 1h, 5);
  fs::create_directory(folder / "maps/home/lock");  // as where the file system is read-only
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 5) << "the robot goes on in it";
  EXPECT_EQ(keeper.name(), "home");
  EXPECT_THAT(keeper.problem().words(),
              AllOf(HasSubstr("lock"), HasSubstr("the map is not stored"), HasSubstr("tries again")));
  EXPECT_FALSE(keeper.mayWrite(kNow + 100s));
  EXPECT_FALSE(keeper.checkpoint(kNow, ChangingMap(6).map));
  EXPECT_FALSE(keeper.retry(kNow + 1s));
  EXPECT_NE(keeper.problem().words(), "");
  fs::remove(folder / "maps/home/lock");
  ASSERT_TRUE(keeper.retryDue(kNow + 10s));
  EXPECT_FALSE(keeper.retry(kNow + 10s)) << "the robot is in it already";
  EXPECT_EQ(keeper.problem().words(), "");
  ASSERT_TRUE(keeper.mayWrite(kNow + 11s));
  EXPECT_FALSE(keeper.hasJournal());
  EXPECT_TRUE(keeper.checkpoint(kNow + 11s, ChangingMap(6).map));
  EXPECT_EQ(newestKeyframes("home"), 6);
}

TEST_F(MapKeeping, WritesOverNobodysMapWhenTheDiskCanBeWrittenAgain) {
  store("home", 1h, 5);
  fs::create_directory(folder / "maps/home/lock");
  MapKeeper keeper(config);
  keeper.begin(kNow);
  EXPECT_FALSE(keeper.retry(kNow + 1s));
  MapStore(folder / "maps", "home").checkpoint(ChangingMap(9).map);  // by somebody else
  EXPECT_FALSE(keeper.retry(kNow + 5s));
  fs::remove(folder / "maps/home/lock");
  EXPECT_FALSE(keeper.retry(kNow + 10s));
  EXPECT_NE(keeper.name(), "home");
  EXPECT_TRUE(keeper.checkpoint(kNow + 11s, ChangingMap(6).map));
  EXPECT_EQ(newestKeyframes("home"), 9);
  EXPECT_EQ(newestKeyframes(keeper.name()), 6);
}

TEST_F(MapKeeping, BeginsWithoutTheFolderOfAllMapsAndStoresWhenItCanBeMade) {
  folder.write("disk", "not mounted yet");
  config.store.directory = folder / "disk/maps";
  for (const char* name : {"", "kitchen"}) {
    config.store.map = name;
    MapKeeper keeper(config);
    EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 0);
    EXPECT_THAT(keeper.problem().words(), AllOf(HasSubstr("disk/maps"), HasSubstr("or make the folder")));
    EXPECT_FALSE(keeper.checkpoint(kNow, ChangingMap(3).map));
    fs::remove_all(folder / "disk");
    EXPECT_FALSE(keeper.retry(kNow + 5s));
    EXPECT_EQ(keeper.problem().words(), "");
    EXPECT_TRUE(keeper.checkpoint(kNow + 6s, ChangingMap(3).map));
    EXPECT_EQ(MapStore::list(config.store.directory).size(), 1U);
    fs::remove_all(folder / "disk");
    folder.write("disk", "not mounted yet");
  }
}

TEST_F(MapKeeping, TakesTheNamedMapOfADiskThatComesLate) {
  store("kitchen", 1h, 5);
  fs::rename(folder / "maps", folder / "disk in the drawer");
  folder.write("maps", "not mounted yet");
  config.store.map = "kitchen";
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 0);
  fs::remove(folder / "maps");
  fs::rename(folder / "disk in the drawer", folder / "maps");
  const auto found = keeper.retry(kNow + 5s);
  ASSERT_TRUE(found) << "it is not written over by what was drawn meanwhile";
  EXPECT_EQ(found->keyframes.size(), 5);
}

TEST_F(MapKeeping, StoresTheWholeMapAgainWhereItsFolderWasRemoved) {
  MapKeeper keeper(config);
  keeper.begin(kNow);
  ChangingMap changing;
  ASSERT_TRUE(keeper.checkpoint(kNow, changing.map));
  fs::remove_all(folder / "maps");
  changing.addKeyframe(true);
  EXPECT_FALSE(keeper.journal(kNow + 10s, changing.map)) << "into a file without a name";
  EXPECT_THAT(keeper.problem().words(), HasSubstr("removed the map's folder"));
  EXPECT_FALSE(keeper.retry(kNow + 20s));
  EXPECT_FALSE(keeper.hasJournal()) << "there is nothing that it would follow";
  ASSERT_TRUE(keeper.mayWrite(kNow + 21s));
  EXPECT_TRUE(keeper.checkpoint(kNow + 21s, changing.map));
  EXPECT_EQ(newestKeyframes(keeper.name()), 5);
}

TEST_F(MapKeeping, BeginsInANamedFolderThatNothingWasStoredIn) {
  config.store.map = "kitchen";
  MapKeeper(config).begin(kNow);  // killed before its first checkpoint
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin(kNow).keyframes.size(), 0);
  EXPECT_EQ(keeper.problem().words(), "");
  EXPECT_TRUE(keeper.checkpoint(kNow, ChangingMap(3).map));
}

TEST_F(MapKeeping, TriesToWriteLessOftenWhileItFails) {
  MapKeeper keeper(config);
  keeper.begin(kNow);
  ChangingMap changing;
  ASSERT_TRUE(keeper.checkpoint(kNow, changing.map));
  const test::FileSizeLimit limit(20);
  int attempts = 0;
  for (Timestamp now = kNow + 1s; now < kNow + 101s; now += 50ms) {
    changing.touch();
    if (!keeper.mayWrite(now)) continue;
    EXPECT_FALSE(keeper.journal(now, changing.map));
    ++attempts;
  }
  EXPECT_GE(attempts, 4);
  EXPECT_LE(attempts, 10);
}

TEST_F(MapKeeping, TakesNoOtherMapsFolderForANewOne) {
  MapKeeper first(config), second(config);
  first.begin(kNow);
  EXPECT_TRUE(first.checkpoint(Timestamp(1h), ChangingMap().map));
  damage(first.name());
  second.begin(kNow);  // within the same second
  EXPECT_NE(first.name(), second.name());
  const std::string before = second.name();
  second.beginNew(kNow);
  EXPECT_NE(second.name(), before);
}

TEST_F(MapKeeping, ChangesToAnotherMapOrStaysInTheOneItHas) {
  store("home", 1h, 5);
  store("hall", 2h, 3);
  MapKeeper keeper(config);
  keeper.begin(kNow);
  EXPECT_EQ(keeper.load("hall", kNow).keyframes.size(), 3);
  EXPECT_EQ(keeper.name(), "hall");
  for (const char* bad : {"missing", "../maps/home", "", "/etc"}) {
    EXPECT_NE(refusalOf([&] { keeper.load(bad, kNow); }), "") << bad;
    EXPECT_EQ(keeper.name(), "hall");
  }
  EXPECT_TRUE(keeper.checkpoint(Timestamp(1h), ChangingMap(4).map));
  EXPECT_EQ(newestKeyframes("hall"), 4);
  EXPECT_EQ(newestKeyframes("home"), 5);
}

TEST_F(MapKeeping, SavesACopyUnderAnotherName) {
  store("home", 1h, 5);
  MapKeeper keeper(config);
  const MapState map = keeper.begin(kNow);
  keeper.saveAs("copy", map);
  EXPECT_EQ(keeper.name(), "home");
  EXPECT_EQ(newestKeyframes("copy"), 5);
  EXPECT_THROW(keeper.saveAs("../copy", map), std::runtime_error);
  EXPECT_THAT(refusalOf([&] { keeper.saveAs("home", map); }), HasSubstr("home open"))
      << "what the journal held afterwards would be lost";
  EXPECT_TRUE(keeper.checkpoint(Timestamp(1h), map));
  keeper.saveAs("later", map);
  EXPECT_EQ(MapStore::newest(config.store.directory), "home") << "a copy is not what a start continues";
}

TEST_F(MapKeeping, LeavesAMapToWhoWritesIt) {
  store("home", 1h, 5);
  store("hall", 2h, 3);
  store("hall2", 2h, 2);
  config.store.map = "home";
  auto first = std::make_unique<MapKeeper>(config);
  first->begin(kNow);
  EXPECT_THAT(refusal(), AllOf(HasSubstr("another slamd"), HasSubstr("a new map that is not stored")));
  MapKeeper waiting(config);
  waiting.begin(kNow);
  EXPECT_FALSE(waiting.retry(kNow + 1s));
  EXPECT_NO_THROW(first->load("home", kNow)) << "it has it itself";
  Config other = config;
  other.store.map = "hall";
  MapKeeper second(other);
  const MapState map = second.begin(kNow);
  EXPECT_THAT(refusalOf([&] { second.load("home", kNow); }), HasSubstr("another slamd"));
  EXPECT_THAT(refusalOf([&] { second.saveAs("home", map); }), HasSubstr("another slamd"));
  EXPECT_EQ(second.name(), "hall");
  first.reset();
  EXPECT_EQ(waiting.retry(kNow + 5s).value().keyframes.size(), 5) << "it is free";
  EXPECT_EQ(waiting.load("hall2", kNow).keyframes.size(), 2);
  EXPECT_EQ(second.load("home", kNow).keyframes.size(), 5);
  other.mode = RunMode::kLocalise;
  EXPECT_NO_THROW(MapKeeper(other).begin(kNow)) << "who only reads needs no lock";
}

TEST_F(MapKeeping, NamesAFullDiskWhileItIsFull) {
  MapKeeper keeper(config);
  keeper.begin(kNow);
  ChangingMap changing;
  ASSERT_TRUE(keeper.checkpoint(Timestamp(100s), changing.map));
  for (int i = 0; i < 6; ++i) changing.addKeyframe(true);
  ASSERT_TRUE(keeper.journal(Timestamp(101s), changing.map));
  EXPECT_EQ(keeper.problem().words(), "");
  {
    const test::FileSizeLimit limit(600);  // the journal is longer
    for (int i = 2; i < 12; ++i) {
      changing.addKeyframe(true);
      keeper.journal(Timestamp(i * 100s), changing.map);
      EXPECT_TRUE(keeper.mayWrite(Timestamp(i * 100s + 50s))) << "it is tried again";
      EXPECT_TRUE(keeper.hasJournal());
      EXPECT_FALSE(keeper.checkpoint(Timestamp(i * 100s), changing.map));
      EXPECT_THAT(keeper.problem().words(), HasSubstr("not stored"));
    }
  }
  keeper.journal(Timestamp(2000s), changing.map);
  EXPECT_EQ(newestKeyframes(keeper.name()), 20) << "also what was refused before";
  changing.addKeyframe(true);
  EXPECT_TRUE(keeper.checkpoint(Timestamp(2100s), changing.map));
  EXPECT_EQ(keeper.problem().words(), "");
  EXPECT_EQ(newestKeyframes(keeper.name()), 21);
}

TEST_F(MapKeeping, ReportsSinceWhenAndHowMuchIsNotOnTheDisk) {
  MapKeeper keeper(config);
  keeper.begin(kNow);
  ChangingMap changing;
  ASSERT_TRUE(keeper.checkpoint(Timestamp(100s), changing.map));
  const int stored = changing.map.keyframes.size();
  EXPECT_EQ(keeper.stored(), stored);
  for (int i = 0; i < 6; ++i) changing.addKeyframe(true);
  {
    const test::FileSizeLimit limit(100);
    EXPECT_FALSE(keeper.journal(Timestamp(200s), changing.map));
  }
  EXPECT_EQ(keeper.stored(), stored);
  EXPECT_THAT(keeper.problem().words(),
              testing::MatchesRegex(
                  "not written since [0-9][0-9]:[0-9][0-9]: .*journal.*File too large; the map is not "
                  "stored, 6 of " +
                  std::to_string(stored + 6) + " keyframes are in memory alone, slamd tries again; fix: make room.*"));
  EXPECT_TRUE(keeper.journal(Timestamp(300s), changing.map));
  EXPECT_EQ(keeper.stored(), stored + 6);
}

TEST_F(MapKeeping, GoesOnInItsMapWhenTheDiskIsBack) {
  MapKeeper keeper(config);
  keeper.begin(kNow);
  ChangingMap changing;
  ASSERT_TRUE(keeper.checkpoint(Timestamp(100s), changing.map));
  const std::string name = keeper.name();
  fs::rename(folder / "maps", folder / "away");
  changing.addKeyframe(true);
  EXPECT_FALSE(keeper.journal(Timestamp(200s), changing.map));
  EXPECT_THAT(keeper.problem().words(), HasSubstr("not written since"));
  ASSERT_TRUE(keeper.retryDue(Timestamp(300s)));
  fs::rename(folder / "away", folder / "maps");
  keeper.retry(Timestamp(300s));
  EXPECT_EQ(keeper.name(), name) << "nobody else has written it";
  ASSERT_TRUE(keeper.mayWrite(Timestamp(300s)));
  EXPECT_TRUE(keeper.checkpoint(Timestamp(300s), changing.map)) << keeper.problem().words();
  EXPECT_EQ(keeper.problem().words(), "");
  EXPECT_EQ(newestKeyframes(name), changing.map.keyframes.size());
}

}  // namespace
}  // namespace slam::map_keeper_test
