// SPDX-License-Identifier: BSD-3-Clause
#include "app/map_keeper.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mapping/map_files.hpp"
#include "support/file_size_limit.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::ChangingMap;
using test::contentOf;
using test::refusalOf;
using testing::AllOf;
using testing::HasSubstr;

class MapKeeping : public testing::Test {
 protected:
  MapKeeping() {
    fs::create_directories(folder / "maps");
    config.store.directory = folder / "maps";
    config.map = test::smallGrid();
    config.localizer.lidar.T_base_lidar = ChangingMap().map.T_base_lidar;
  }
  /// A stored map that was written so long ago.
  void store(const std::string& name, std::chrono::hours age, int keyframes) {
    MapStore(folder / "maps", name).checkpoint(ChangingMap(keyframes).map);
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
  /// What begin() refuses with: one line.
  std::string refusal() const {
    MapKeeper keeper(config);
    const std::string text = refusalOf([&] { keeper.begin(); });
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text;
  }
  int newestKeyframes(const std::string& name) const {
    return MapStore::load(folder / "maps", name, config.map).state.keyframes.size();
  }

  const test::Folder folder;
  Config config;
};

TEST_F(MapKeeping, BeginsInTheNewestMap) {
  store("old", 3h, 3);
  store("new", 1h, 5);
  store("middle", 2h, 4);
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin().keyframes.size(), 5);
  EXPECT_EQ(keeper.name(), "new");
  EXPECT_TRUE(keeper.writes());
}

TEST_F(MapKeeping, BeginsInTheMapThatIsConfigured) {
  store("old", 3h, 3);
  store("new", 1h, 5);
  config.store.map = "old";
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin().keyframes.size(), 3);
  EXPECT_EQ(keeper.name(), "old");
  config.store.map = "kitchen";  // a name for a new one
  MapKeeper other(config);
  EXPECT_EQ(other.begin().keyframes.size(), 0);
  EXPECT_EQ(other.name(), "kitchen");
}

TEST_F(MapKeeping, BeginsANewMapWhereThereIsNone) {
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin().keyframes.size(), 0);
  EXPECT_THAT(keeper.name(), testing::MatchesRegex("map-[0-9]+-[0-9]+"));
  config.store.directory.clear();
  MapKeeper nowhere(config);
  EXPECT_EQ(nowhere.begin().keyframes.size(), 0);
  EXPECT_FALSE(nowhere.writes());
  EXPECT_FALSE(nowhere.checkpointDue(Timestamp(1h), 1));
  EXPECT_FALSE(nowhere.journalDue(Timestamp(1h), {}, 1));
}

TEST_F(MapKeeping, ReadsOnlyWhereItLocalises) {
  store("home", 1h, 5);
  config.mode = "localise";
  MapKeeper keeper(config);
  EXPECT_EQ(keeper.begin().keyframes.size(), 5);
  EXPECT_FALSE(keeper.writes());
  EXPECT_FALSE(keeper.checkpointDue(Timestamp(1h), 1));
  EXPECT_FALSE(keeper.checkpoint(Timestamp(1h), ChangingMap().map, 1));
  EXPECT_EQ(newestKeyframes("home"), 5);
}

TEST_F(MapKeeping, RefusesToLocaliseWithoutAMap) {
  config.mode = "localise";
  EXPECT_THAT(refusal(), AllOf(HasSubstr("needs a map"), HasSubstr("store.map")));
  config.store.map = "kitchen";
  EXPECT_THAT(refusal(), HasSubstr("kitchen: there is no such map"));
  config.store.map = folder / "missing.yaml";
  EXPECT_THAT(refusal(), HasSubstr("missing.yaml: there is no such map"));
  config.store.map.clear();
  config.store.directory.clear();
  EXPECT_THAT(refusal(), HasSubstr("needs a map"));
}

TEST_F(MapKeeping, RefusesAMapOfAnotherLidar) {
  store("home", 1h, 5);
  config.store.map = "home";
  config.localizer.lidar.T_base_lidar.x += 0.1;
  EXPECT_THAT(refusal(), AllOf(HasSubstr("was made with the lidar at"), HasSubstr("mend [lidar]")));
  config.mode = "localise";
  EXPECT_THAT(refusal(), HasSubstr("was made with the lidar at"));
}

TEST_F(MapKeeping, RefusesToExtendAPicture) {
  writeMapFiles(folder / "picture", renderMap(ChangingMap().map.grid), {});
  config.store.map = folder / "picture.yaml";
  EXPECT_THAT(refusal(), HasSubstr("a picture of a map cannot be extended"));
  config.mode = "localise";
  MapKeeper keeper(config);
  EXPECT_TRUE(keeper.begin().picture_only);
  EXPECT_FALSE(keeper.writes());
}

TEST_F(MapKeeping, LeavesADamagedNewestMapAndBeginsANewOne) {
  store("home", 1h, 5);
  damage("home");
  const std::string before = contentOf(folder / "maps/home/000001/keyframes.bin");
  {
    MapKeeper keeper(config);
    EXPECT_EQ(keeper.begin().keyframes.size(), 0);
    EXPECT_NE(keeper.name(), "home");
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(keeper.checkpoint(Timestamp(1h), ChangingMap(3 + i).map, i));
    EXPECT_EQ(names().size(), 2U);
  }
  EXPECT_EQ(contentOf(folder / "maps/home/000001/keyframes.bin"), before);
  EXPECT_FALSE(fs::exists(folder / "maps/home/000002"));
  config.store.map = "home";  // asked for by name it is not silently replaced
  EXPECT_THAT(refusal(), HasSubstr("keyframes.bin: is damaged"));
}

TEST_F(MapKeeping, TakesNoOtherMapsFolderForANewOne) {
  MapKeeper first(config), second(config);
  first.begin();
  EXPECT_TRUE(first.checkpoint(Timestamp(1h), ChangingMap().map, 1));
  damage(first.name());
  second.begin();  // within the same second
  EXPECT_NE(first.name(), second.name());
  const std::string before = second.name();
  second.beginNew();
  EXPECT_NE(second.name(), before);
}

TEST_F(MapKeeping, ChangesToAnotherMapOrStaysInTheOneItHas) {
  store("home", 1h, 5);
  store("hall", 2h, 3);
  MapKeeper keeper(config);
  keeper.begin();
  EXPECT_EQ(keeper.load("hall").keyframes.size(), 3);
  EXPECT_EQ(keeper.name(), "hall");
  for (const char* bad : {"missing", "../maps/home", "", "/etc"}) {
    EXPECT_NE(refusalOf([&] { keeper.load(bad); }), "") << bad;
    EXPECT_EQ(keeper.name(), "hall");
  }
  EXPECT_TRUE(keeper.checkpoint(Timestamp(1h), ChangingMap(4).map, 1));
  EXPECT_EQ(newestKeyframes("hall"), 4);
  EXPECT_EQ(newestKeyframes("home"), 5);
}

TEST_F(MapKeeping, SavesACopyUnderAnotherName) {
  store("home", 1h, 5);
  MapKeeper keeper(config);
  const MapState map = keeper.begin();
  keeper.saveAs("copy", map);
  EXPECT_EQ(keeper.name(), "home");
  EXPECT_EQ(newestKeyframes("copy"), 5);
  EXPECT_THROW(keeper.saveAs("../copy", map), std::runtime_error);
  EXPECT_TRUE(keeper.checkpoint(Timestamp(1h), map, 1));
  keeper.saveAs("later", map);
  EXPECT_EQ(MapStore::newest(config.store.directory), "home") << "a copy is not what a start continues";
}

TEST_F(MapKeeping, LeavesAMapToWhoWritesIt) {
  store("home", 1h, 5);
  store("hall", 2h, 3);
  config.store.map = "home";
  auto first = std::make_unique<MapKeeper>(config);
  first->begin();
  EXPECT_THAT(refusal(), HasSubstr("another slamd"));
  EXPECT_NO_THROW(first->load("home")) << "it has it itself";
  Config other = config;
  other.store.map = "hall";
  MapKeeper second(other);
  const MapState map = second.begin();
  EXPECT_THAT(refusalOf([&] { second.load("home"); }), HasSubstr("another slamd"));
  EXPECT_THAT(refusalOf([&] { second.saveAs("home", map); }), HasSubstr("another slamd"));
  EXPECT_EQ(second.name(), "hall");
  first.reset();
  EXPECT_EQ(second.load("home").keyframes.size(), 5);
  other.mode = "localise";
  EXPECT_NO_THROW(MapKeeper(other).begin()) << "who only reads needs no lock";
}

TEST_F(MapKeeping, WritesACheckpointAtOnceAndThenByItsPeriod) {
  config.store.checkpoint_period = 60.0;
  MapKeeper keeper(config);
  keeper.begin();
  const ChangingMap changing;
  EXPECT_TRUE(keeper.checkpointDue(Timestamp(100s), 1)) << "there is no journal before it";
  EXPECT_FALSE(keeper.journalDue(Timestamp(100s), {}, 1));
  EXPECT_TRUE(keeper.checkpoint(Timestamp(100s), changing.map, 1));
  EXPECT_FALSE(keeper.checkpointDue(Timestamp(500s), 1)) << "nothing changed";
  EXPECT_FALSE(keeper.checkpointDue(Timestamp(159s), 2));
  EXPECT_TRUE(keeper.checkpointDue(Timestamp(160s), 2));
}

TEST_F(MapKeeping, WritesTheJournalWhenSomethingChangedOrTheRobotMoved) {
  config.store.journal_period = 2.0;
  MapKeeper keeper(config);
  keeper.begin();
  ChangingMap changing;
  const Pose2 pose = changing.map.T_map_base;
  EXPECT_TRUE(keeper.checkpoint(Timestamp(100s), changing.map, 1));
  EXPECT_FALSE(keeper.journalDue(Timestamp(200s), pose * Pose2{0.05, 0.0, 0.05}, 1));
  EXPECT_TRUE(keeper.journalDue(Timestamp(200s), pose * Pose2{0.11, 0.0, 0.0}, 1));
  EXPECT_TRUE(keeper.journalDue(Timestamp(200s), pose * Pose2{0.0, 0.0, -0.11}, 1));
  EXPECT_TRUE(keeper.journalDue(Timestamp(200s), pose, 2));
  changing.addKeyframe(true);
  keeper.journal(Timestamp(200s), changing.map, {}, 2);
  EXPECT_FALSE(keeper.journalDue(Timestamp(300s), pose, 2));
  EXPECT_FALSE(keeper.journalDue(Timestamp(201s), pose, 3));
  EXPECT_TRUE(keeper.journalDue(Timestamp(202s), pose, 3));
  EXPECT_EQ(newestKeyframes(keeper.name()), 5);
}

TEST_F(MapKeeping, LogsAFullDiskOnceAndItsEndOnce) {
  MapKeeper keeper(config);
  keeper.begin();
  ChangingMap changing;
  ASSERT_TRUE(keeper.checkpoint(Timestamp(100s), changing.map, 1));
  testing::internal::CaptureStderr();
  {
    const test::FileSizeLimit limit(200);
    for (int i = 2; i < 12; ++i) {
      changing.addKeyframe(true);
      keeper.journal(Timestamp(i * 100s), changing.map, {}, i);
      EXPECT_TRUE(keeper.journalDue(Timestamp(i * 100s + 50s), changing.map.T_map_base, i)) << "it is tried again";
      EXPECT_FALSE(keeper.checkpoint(Timestamp(i * 100s), changing.map, i));
      EXPECT_TRUE(keeper.checkpointDue(Timestamp(i * 100s + 1000s), i));
    }
  }
  const std::string failing = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(failing.begin(), failing.end(), '\n'), 1) << failing;
  EXPECT_THAT(failing, HasSubstr("not written"));
  testing::internal::CaptureStderr();
  keeper.journal(Timestamp(2000s), changing.map, {}, 12);
  EXPECT_EQ(newestKeyframes(keeper.name()), 14) << "also what was refused before";
  changing.addKeyframe(true);
  EXPECT_TRUE(keeper.checkpoint(Timestamp(2100s), changing.map, 13));
  const std::string again = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(again.begin(), again.end(), '\n'), 1) << again;
  EXPECT_THAT(again, HasSubstr("written again"));
  EXPECT_EQ(newestKeyframes(keeper.name()), 15);
}

}  // namespace
}  // namespace slam
