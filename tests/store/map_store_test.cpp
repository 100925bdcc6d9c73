// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_store.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <limits>
#include <optional>
#include <sys/stat.h>
#include <vector>

#include "mapping/map_files.hpp"
#include "store/sync_log.hpp"
#include "support/file_size_limit.hpp"
#include "support/irremovable.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::map_store_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::ChangingMap;
using test::contentOf;
using test::differenceOf;
using test::Folder;
using test::refusalOf;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const OccupancyGridConfig kGrid = test::smallGrid();

/// A map of two generations, each with a journal, and the map as it was at each writing.
class Drive {
 public:
  explicit Drive(const fs::path& directory, const std::string& name = "home") : store(directory, name) {
    checkpoint();
    changing.addKeyframe(true);
    append();
    changing.addKeyframe(false);
    changing.closeLoop(0, 3);
    append();
    changing.map.in_map.back() = 1;
    changing.move();
    changing.addKeyframe(true);
    changing.touch();
    checkpoint();  // also the journal's last record
    changing.addKeyframe(true);
    changing.map.keyframes.graph().revoke(2);
    append();
    changing.addKeyframe(false);
    changing.touch();
    append();
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
  /// Which of the states it is; -1: none, so that it is made up.
  int find(const MapState& map) const {
    for (std::size_t i = states.size(); i-- > 0;) {
      if (differenceOf(map, states[i]).empty()) return static_cast<int>(i);
    }
    return -1;
  }

  MapStore store;
  ChangingMap changing;
  std::vector<MapState> states;
};
constexpr int kFirst = 0, kSecond = 3, kLast = 5;  // states: of generation 1, of generation 2, of all

const char* const kFiles[] = {"keyframes.bin", "graph.bin", "grid.bin", "state.toml", "MANIFEST"};

/// Calls body() for each byte of a file with that byte flipped, and repairs the file.
template <typename Body>
void forEachFlip(const fs::path& file, Body&& body) {
  const std::string whole = contentOf(file);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const char flip : {'\x01', '\x08', '\xFF'}) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ flip);
      std::ofstream(file, std::ios::binary) << damaged;
      body(file.filename().string() + " byte " + std::to_string(at));
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  std::ofstream(file, std::ios::binary) << whole;
}

void damage(const fs::path& file) {
  std::string content = contentOf(file);
  content.at(content.size() / 2) ^= '\x10';
  std::ofstream(file, std::ios::binary) << content;
}

/// The grid shows the keyframes that are said to be drawn.
void expectGridOf(const LoadedMap& loaded) {
  Mapper mapper(kGrid);
  mapper.load(scansOf(loaded.state), viewsOf(loaded.state), loaded.state.grid.clone(), loaded.state.grid_keyframes);
  EXPECT_TRUE(test::sameCells(mapper.grid(), test::drawn(loaded.state)));
}

bool oneSentence(const std::string& text) { return !text.empty() && text.find('\n') == std::string::npos; }

TEST(MapStore, ShowsWhatTheDepthCameraSawSinceTheCheckpoint) {
  for (const bool moved : {false, true}) {
    SCOPED_TRACE(moved ? "the map moved" : "the map stayed");
    const Folder folder;
    Drive drive(folder / "");
    drive.changing.addKeyframe(true);
    const int id = drive.changing.map.keyframes.size() - 1;
    const MapView seen = test::viewFrom(id, drive.changing.map.keyframes.pose(id));
    drive.store.append(drive.changing.map, std::vector<MapView>{seen});
    if (moved) drive.changing.move();
    drive.append();
    const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
    EXPECT_THAT(loaded.remarks, IsEmpty());
    ASSERT_EQ(loaded.state.views.size(), 1U);
    expectGridOf(loaded);
  }
}

TEST(MapStore, FallsBackWithTheViewsThatCameBeforeTheDamagedCheckpoint) {
  const Folder folder;
  Drive drive(folder / "");
  drive.changing.addKeyframe(true);
  const int id = drive.changing.map.keyframes.size() - 1;
  drive.store.checkpoint(drive.changing.map,
                         std::vector<MapView>{test::viewFrom(id, drive.changing.map.keyframes.pose(id))});
  damage(folder / "home" / "000003" / "keyframes.bin");
  const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
  EXPECT_EQ(loaded.generation, 2);
  EXPECT_EQ(loaded.state.views.size(), 1U);
}

TEST(MapStore, LoadsWhatWasWrittenLast) {
  const Folder folder;
  const Drive drive(folder / "");
  const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
  EXPECT_EQ(drive.find(loaded.state), kLast) << differenceOf(loaded.state, drive.states.back());
  EXPECT_EQ(loaded.generation, 2);
  EXPECT_THAT(loaded.remarks, IsEmpty());
  expectGridOf(loaded);
}

TEST(MapStore, LoadsTheSameFromTheGenerationBeforeAndBothJournals) {
  for (const char* file : {"keyframes.bin", "graph.bin", "state.toml", "MANIFEST"}) {
    const Folder folder;
    const Drive drive(folder / "");
    damage(folder / "home/000002" / file);
    const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
    EXPECT_EQ(drive.find(loaded.state), kLast) << file;
    EXPECT_EQ(loaded.generation, 1);
    ASSERT_EQ(loaded.remarks.size(), 1U);
    EXPECT_THAT(loaded.remarks[0], AllOf(HasSubstr(file), HasSubstr("used generation 1 instead")));
    expectGridOf(loaded);
  }
}

TEST(MapStore, LosesNothingByAFlippedByteInTheNewestGeneration) {
  const Folder folder;
  const Drive drive(folder / "");
  for (const char* name : kFiles) {
    const bool grid = std::string(name) == "grid.bin";
    forEachFlip(folder / "home/000002" / name, [&](const std::string& where) {
      const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
      ASSERT_EQ(drive.find(loaded.state), kLast) << where;
      ASSERT_EQ(loaded.remarks.size(), 1U) << where;
      ASSERT_EQ(loaded.generation, grid ? 2 : 1) << where;
      ASSERT_TRUE(test::sameCells(loaded.state.grid, test::drawn(loaded.state))) << where;
    });
  }
}

TEST(MapStore, OfEveryFlippedBitLosesNoMoreThanAJournalsEndAndListsWhatItLoads) {
  const Folder folder;
  ChangingMap changing(2);
  changing.map.views = {test::viewFrom(1, changing.map.keyframes.pose(1))};
  MapStore store(folder / "", "home");
  std::vector<MapState> states;  // as they were written
  const auto written = [&] { states.push_back(changing.copy()); };
  store.checkpoint(changing.map), written();
  changing.addKeyframe(true);
  store.append(changing.map), written();
  changing.touch();
  store.checkpoint(changing.map), written();
  changing.addKeyframe(true);
  store.append(changing.map), written();
  const auto find = [&](const MapState& map) {
    return std::find_if(states.begin(), states.end(), [&](const MapState& s) { return differenceOf(map, s).empty(); });
  };
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "home")) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  ASSERT_EQ(files.size(), 14U) << "six files and a journal of each generation";
  for (const fs::path& file : files) {
    const std::string whole = contentOf(file);
    std::fstream on_disk(file, std::ios::in | std::ios::out | std::ios::binary);
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      const auto at = static_cast<std::streamoff>(bit / 8);
      const auto put = [&](int byte) { on_disk.seekp(at).put(static_cast<char>(byte)).flush(); };
      put(whole[bit / 8] ^ (1 << bit % 8));
      const std::string where = file.string() + " byte " + std::to_string(at) + " bit " + std::to_string(bit % 8);
      LoadedMap loaded;
      ASSERT_NO_THROW(loaded = MapStore::load(folder / "", "home", kGrid)) << where;
      const auto state = find(loaded.state);
      ASSERT_NE(state, states.end()) << where << ": a map that was never written";
      std::string remarks;
      for (const std::string& remark : loaded.remarks) {
        ASSERT_TRUE(oneSentence(remark)) << where;
        ASSERT_THAT(remark, AllOf(HasSubstr(file.string()), Not(HasSubstr("newer")))) << where;
        remarks += (remarks.empty() ? "" : "; ") + remark;
      }
      const std::string name = file.lexically_relative(folder / "home").string();
      const bool newest = name.starts_with("000002");  // the other one is not needed
      ASSERT_EQ(loaded.remarks.size(), newest ? 1U : 0U) << where;
      const bool last = state == states.end() - 1;
      ASSERT_TRUE(last || file.extension() == ".journal") << where;
      if (bit % 8 == 0 || file.filename() == "MANIFEST") {
        const auto listed = MapStore::list(folder / "");
        ASSERT_EQ(listed.size(), 1U) << where;
        ASSERT_EQ(listed[0].generation, loaded.generation) << where;
        ASSERT_EQ(listed[0].problem, remarks) << where;
      }
      put(whole[bit / 8]);
    }
  }
}

TEST(MapStore, LosesNothingByAFlippedByteInTheGenerationBefore) {
  const Folder folder;
  const Drive drive(folder / "");
  const auto unchanged = [&](const std::string& where) {
    const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
    ASSERT_EQ(drive.find(loaded.state), kLast) << where;
    ASSERT_THAT(loaded.remarks, IsEmpty()) << where;
  };
  for (const char* name : kFiles) forEachFlip(folder / "home/000001" / name, unchanged);
  forEachFlip(folder / "home/000001.journal", unchanged);
}

TEST(MapStore, LosesOnlyTheJournalsEndByAFlippedByteInIt) {
  const Folder folder;
  const Drive drive(folder / "");
  forEachFlip(folder / "home/000002.journal", [&](const std::string& where) {
    const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
    const int state = drive.find(loaded.state);
    ASSERT_TRUE(state >= kSecond && state < kLast) << where;
    ASSERT_EQ(loaded.remarks.size(), 1U) << where;
    ASSERT_THAT(loaded.remarks[0], HasSubstr("cut off")) << where;
  });
  damage(folder / "home/000002/graph.bin");
  forEachFlip(folder / "home/000001.journal", [&](const std::string& where) {
    const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
    const int state = drive.find(loaded.state);
    ASSERT_TRUE(state >= kFirst && state < kSecond) << where;
    ASSERT_EQ(loaded.remarks.size(), 2U) << where;
  });
}

TEST(MapStore, ReportsInOneSentenceThatNoGenerationIsIntact) {
  const Folder folder;
  const Drive drive(folder / "");
  damage(folder / "home/000002/keyframes.bin");
  for (const char* name : {"keyframes.bin", "graph.bin", "state.toml", "MANIFEST"}) {
    forEachFlip(folder / "home/000001" / name, [&](const std::string& where) {
      std::optional<LoadedMap> loaded;
      const std::string refusal = refusalOf([&] { loaded = MapStore::load(folder / "", "home", kGrid); });
      if (loaded) {  // of its last byte, a line's end, nothing depends
        ASSERT_EQ(drive.find(loaded->state), kLast) << where;
      } else {
        ASSERT_TRUE(oneSentence(refusal)) << refusal;
        ASSERT_THAT(refusal, AllOf(HasSubstr((folder / "home").string()))) << where;
      }
    });
  }
}

TEST(MapStore, ReadsAMapWhoseJournalIsCutAnywhere) {
  const Folder folder;
  const Drive drive(folder / "");
  const std::string whole = contentOf(folder / "home/000002.journal");
  int before = kSecond;
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    folder.write("home/000002.journal", whole.substr(0, size));
    const int state = drive.find(MapStore::load(folder / "", "home", kGrid).state);
    ASSERT_GE(state, before) << size;
    before = state;
  }
  EXPECT_EQ(before, kLast);
}

TEST(MapStore, GoesBehindAGenerationWithAFileMissing) {
  for (const char* name : kFiles) {
    const Folder folder;
    const Drive drive(folder / "");
    fs::remove(folder / "home/000002" / name);
    const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
    EXPECT_EQ(drive.find(loaded.state), kLast) << name;
    EXPECT_EQ(loaded.remarks.size(), 1U);
    expectGridOf(loaded);
  }
}

TEST(MapStore, LosesNothingByACheckpointThatWasInterrupted) {
  const Folder folder;
  Drive drive(folder / "");
  const fs::path map = folder / "home";
  const auto expectAll = [&](const std::string& stage) {
    const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
    EXPECT_EQ(drive.find(loaded.state), kLast) << stage;
    EXPECT_THAT(loaded.remarks, IsEmpty()) << stage;
  };
  fs::create_directory(map / "writing");
  expectAll("begun");
  for (const char* name : kFiles) {
    const std::string content = contentOf(map / "000002" / name);
    folder.write(std::string("home/writing/") + name, content.substr(0, content.size() / 2));
    expectAll(std::string("half of ") + name);
    folder.write(std::string("home/writing/") + name, content);
    expectAll(std::string("all of ") + name);
  }
  // Renamed, and the power went before the journal was there; the other way round; with a torn journal.
  for (const bool renamed : {true, false}) {
    const Folder copy;
    fs::copy(map, copy / "home", fs::copy_options::recursive);
    MapStore next(copy / "", "home");
    drive.changing.map.grid = test::drawn(drive.changing.map);
    next.checkpoint(drive.changing.map);
    renamed ? fs::remove(copy / "home/000003.journal") : fs::remove_all(copy / "home/000003") > 0;
    if (!renamed) {
      fs::copy(map / "000001", copy / "home/000001", fs::copy_options::recursive | fs::copy_options::skip_existing);
    }
    const LoadedMap loaded = MapStore::load(copy / "", "home", kGrid);
    EXPECT_EQ(drive.find(loaded.state), kLast) << renamed;
    EXPECT_THAT(loaded.remarks, IsEmpty()) << renamed;
  }
  drive.changing.addKeyframe(true);
  drive.checkpoint();  // the next one clears the rest away
  EXPECT_FALSE(fs::exists(map / "writing"));
  EXPECT_EQ(MapStore::load(folder / "", "home", kGrid).generation, 3);
}

TEST(MapStore, AppliesNoJournalToAMapThatItDoesNotContinue) {
  // The map is loaded and extended before the first checkpoint; that the journal before it does not know.
  const Folder folder;
  { const Drive drive(folder / ""); }
  LoadedMap first = MapStore::load(folder / "", "home", kGrid);
  ChangingMap changing(static_cast<int>(first.state.keyframes.size()) + 3);
  MapStore store(folder / "", "home");
  store.checkpoint(changing.map);
  changing.addKeyframe(true);
  store.append(changing.map);
  damage(folder / "home/000003/keyframes.bin");
  const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
  EXPECT_EQ(differenceOf(loaded.state, first.state), "");
  ASSERT_EQ(loaded.remarks.size(), 2U);
  EXPECT_THAT(loaded.remarks[1], HasSubstr("000003.journal: cut off behind record 0"));
}

TEST(MapStore, KeepsTwoGenerations) {
  const Folder folder;
  Drive drive(folder / "");
  for (int i = 0; i < 5; ++i) {
    drive.changing.addKeyframe(true);
    drive.checkpoint();
  }
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder / "home")) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  EXPECT_THAT(names, ElementsAre("000006", "000006.journal", "000007", "000007.journal"));
}

TEST(MapStore, KeepsTheGenerationThatItFellBackTo) {
  const Folder folder;
  { const Drive drive(folder / ""); }
  damage(folder / "home/000002/keyframes.bin");
  const MapState map = MapStore::load(folder / "", "home", kGrid).state;
  MapStore store(folder / "", "home");
  store.checkpoint(map);
  damage(folder / "home/000003/keyframes.bin");
  EXPECT_EQ(MapStore::load(folder / "", "home", kGrid).generation, 1);
  store.checkpoint(map);
  store.checkpoint(map);
  EXPECT_FALSE(fs::exists(folder / "home/000001"));
  EXPECT_FALSE(fs::exists(folder / "home/000002.journal"));
  EXPECT_TRUE(fs::exists(folder / "home/000004"));
}

TEST(MapStore, GoesOnCountingInAStoredMap) {
  const Folder folder;
  { const Drive drive(folder / ""); }
  LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
  MapStore store(folder / "", "home");
  store.append(loaded.state);  // without a checkpoint it has nothing to add to
  store.checkpoint(loaded.state);
  EXPECT_EQ(MapStore::load(folder / "", "home", kGrid).generation, 3);
  EXPECT_TRUE(fs::exists(folder / "home/000002"));
}

TEST(MapStore, LeavesAMapOfANewerSlamdAlone) {
  const Folder folder;
  const Drive drive(folder / "");
  const fs::path manifest = folder / "home/000002/MANIFEST";
  std::string text = contentOf(manifest);
  text.replace(text.find("version 1"), 9, "version 3");
  text.resize(text.rfind("crc32 "));
  text += "crc32 " + std::to_string(crc32Of(text)) + "\n";
  std::ofstream(manifest, std::ios::binary) << text;
  const std::string refusal = refusalOf([&] { MapStore::load(folder / "", "home", kGrid); });
  EXPECT_THAT(refusal, AllOf(HasSubstr("format 3"), HasSubstr("newer slamd"), HasSubstr("update slamd")));
  EXPECT_TRUE(oneSentence(refusal));
  const MapSummary listed = MapStore::list(folder / "")[0];
  EXPECT_EQ(listed.problem, refusal);
  EXPECT_EQ(listed.generation, 0) << "the one before it is not to be used";
  EXPECT_TRUE(listed.newer);
}

TEST(MapStore, AFullDiskLeavesTheGenerationsBeforeAndTheJournalGoesOn) {
  const Folder folder;
  Drive drive(folder / "");
  const auto largest = fs::file_size(folder / "home/000002/keyframes.bin");
  for (const auto bytes : {std::uintmax_t{0}, std::uintmax_t{100}, largest}) {
    drive.changing.addKeyframe(true);
    drive.changing.touch();
    {
      const test::FileSizeLimit limit(bytes);
      EXPECT_TRUE(oneSentence(refusalOf([&] { drive.store.checkpoint(drive.changing.map); })));
    }
    EXPECT_FALSE(fs::exists(folder / "home/writing")) << "the journal needs the room";
    drive.append();
    const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
    EXPECT_EQ(loaded.generation, 2);
    EXPECT_THAT(loaded.remarks, IsEmpty());
    EXPECT_EQ(differenceOf(loaded.state, drive.changing.map), "");
  }
  drive.checkpoint();
  EXPECT_EQ(MapStore::load(folder / "", "home", kGrid).generation, 3);
}

TEST(MapStore, ACheckpointWorksAgainAfterOneThatFailedAtItsEnd) {
  const Folder folder;
  Drive drive(folder / "");
  fs::rename(folder / "home", folder / "away");
  EXPECT_THROW(drive.store.checkpoint(drive.changing.map), std::exception);
  drive.append();
  fs::rename(folder / "away", folder / "home");
  EXPECT_EQ(MapStore::load(folder / "", "home", kGrid).generation, 2);
  drive.checkpoint();
  drive.changing.addKeyframe(true);
  drive.append();
  const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
  EXPECT_EQ(loaded.generation, 3);
  EXPECT_EQ(differenceOf(loaded.state, drive.changing.map), "");
}

TEST(MapStore, TakesNamesThatAreNoPaths) {
  const Folder folder;
  for (const char* good : {"home", "map-20260101-120000", "a.b", "_", "A_9"})
    EXPECT_TRUE(MapStore::isName(good)) << good;
  for (const std::string bad : {"", ".", "..", "../x", "a/b", "/tmp/x", ".hidden", "a b", "a\n", "ä", "a;b"}) {
    EXPECT_FALSE(MapStore::isName(bad)) << bad;
    EXPECT_TRUE(oneSentence(refusalOf([&] { MapStore(folder / "maps", bad); })) || bad == "a\n") << bad;
  }
  EXPECT_FALSE(MapStore::isName(std::string("a\0b", 3)));
  EXPECT_FALSE(MapStore::isName(std::string(101, 'a')));
  EXPECT_FALSE(fs::exists(folder / "maps")) << "a refusal makes no folder";
}

TEST(MapStore, RefusesWhatIsNoMap) {
  const Folder folder;
  fs::create_directories(folder / "empty");
  fs::create_directories(folder / "odd/000001");
  folder.write("odd/000002", "a file");
  for (const char* name : {"missing", "empty", "odd"}) {
    EXPECT_TRUE(oneSentence(refusalOf([&] { MapStore::load(folder / "", name, kGrid); }))) << name;
  }
}

TEST(MapStore, ListsMapsAndTheirDamage) {
  const Folder folder;
  EXPECT_THAT(MapStore::list(folder / "maps"), IsEmpty());
  EXPECT_EQ(MapStore::newest(folder / "maps"), std::nullopt);
  const Drive good(folder / "maps", "good"), half(folder / "maps", "half"), bad(folder / "maps", "bad");
  fs::create_directories(folder / "maps/no map");
  fs::create_directories(folder / "maps/empty");
  folder.write("maps/file", "");
  damage(folder / "maps/half/000002/graph.bin");
  for (const char* generation : {"000001", "000002"}) damage(folder / "maps/bad" / generation / "state.toml");
  const auto maps = MapStore::list(folder / "maps");
  ASSERT_EQ(maps.size(), 3U);
  EXPECT_EQ(maps[0].name, "bad");
  EXPECT_EQ(maps[0].generation, 0);
  EXPECT_THAT(maps[0].problem, HasSubstr("000002/state.toml: is damaged"));
  EXPECT_EQ(maps[1].name, "good");
  EXPECT_EQ(maps[1].generation, 2);
  EXPECT_EQ(maps[1].keyframes, good.states[kSecond].keyframes.size());
  EXPECT_EQ(maps[1].utime, good.states[kSecond].utime);
  EXPECT_EQ(maps[1].problem, "");
  EXPECT_EQ(maps[0].problem, refusalOf([&] { MapStore::load(folder / "maps", "bad", kGrid); }));
  EXPECT_EQ(maps[2].problem, MapStore::load(folder / "maps", "half", kGrid).remarks.at(0));
  EXPECT_EQ(maps[2].generation, 1);
  EXPECT_EQ(maps[2].newest, 2);
  EXPECT_THAT(maps[2].problem, HasSubstr("graph.bin"));
  for (const char* file : {"grid.bin", "depth.bin"}) {  // without which a map can be loaded
    const std::string others = std::string("others of ") + file;
    const Drive drive(folder / others, "home");
    damage(folder / others / "home/000002" / file);
    const auto listed = MapStore::list(folder / others);
    EXPECT_EQ(listed[0].generation, 2) << file;
    EXPECT_THAT(listed[0].problem, HasSubstr(file));
  }
}

/// Sets all times of a map's files, as a clock would that is wrong by so much.
void dateBack(const fs::path& map, std::chrono::hours age) {
  for (const auto& entry : fs::directory_iterator(map)) {
    fs::last_write_time(entry.path(), fs::file_time_type::clock::now() - age);
  }
}

TEST(MapStore, TheNewestMapIsTheOneGoneOnInLastWhateverTheClockRead) {
  const Folder folder;
  Drive a(folder / "", "a");
  dateBack(folder / "a", -24h * 365 * 10);  // a clock ten years ahead
  Drive b(folder / "", "b");
  EXPECT_EQ(MapStore::newest(folder / ""), "b");
  dateBack(folder / "b", 24h * 365 * 50);
  b.changing.addKeyframe(true);
  b.append();
  EXPECT_EQ(MapStore::newest(folder / ""), "b");
  a.checkpoint();
  dateBack(folder / "a", 24h * 365 * 50);
  EXPECT_EQ(MapStore::newest(folder / ""), "a") << "slamctl load a";
  a.checkpoint(), a.checkpoint();
  EXPECT_EQ(MapStore::newest(folder / ""), "a");
  a.store.writeCopy(a.changing.map);
  EXPECT_EQ(MapStore::newest(folder / ""), "b") << "what is only a copy is not gone on in";
  fs::remove_all(folder / "b");
  EXPECT_EQ(MapStore::newest(folder / ""), "a") << "it is better than none";
}

TEST(MapStore, AStoreRestoredFromElsewhereIsPutInOrderByWhatIsWrittenNext) {
  const Folder folder;
  Drive home(folder / "", "home");
  fs::copy(folder / "home", folder / "backup", fs::copy_options::recursive);
  dateBack(folder / "backup", -1h);  // the same order, and younger
  home.checkpoint();
  EXPECT_EQ(MapStore::newest(folder / ""), "home");
}

TEST(MapStore, MapsOfASlamdThatCountedNoOrderFollowByTheirFilesTimes) {
  const Folder folder;
  Drive old(folder / "", "old"), older(folder / "", "older");
  for (MapStore* store : {&old.store, &older.store}) {  // an order of 0 is no line
    store->writeCopy(old.changing.map), store->writeCopy(old.changing.map);
  }
  EXPECT_THAT(contentOf(folder / "old/000004/MANIFEST"), Not(HasSubstr("order")));
  dateBack(folder / "old", 1h), dateBack(folder / "older", 2h);
  folder.write("older/notes.txt", "written today, and nothing of the map");
  EXPECT_EQ(MapStore::newest(folder / ""), "old");
  fs::last_write_time(folder / "older/000004.journal", fs::file_time_type::clock::now());
  EXPECT_EQ(MapStore::newest(folder / ""), "older") << "a journal counts";
  old.checkpoint();
  EXPECT_EQ(MapStore::newest(folder / ""), "old") << "what has an order is newer";
}

TEST(MapStore, AMapOfANewerSlamdKeepsItsPlaceInTheOrder) {
  const Folder folder;
  const Drive first(folder / "", "first"), last(folder / "", "last");
  const fs::path manifest = folder / "last/000002/MANIFEST";
  std::string text = contentOf(manifest);
  text.replace(text.find("version 1"), 9, "version 3");
  text.resize(text.rfind("crc32 "));
  std::ofstream(manifest, std::ios::binary) << text << "crc32 " << crc32Of(text) << "\n";
  EXPECT_EQ(MapStore::newest(folder / ""), "last") << "an older map is not silently gone on in";
}

/// Something strange in the folder of the maps, and what a start says of it.
struct Strange {
  const char* what;
  void (*put)(const fs::path& maps);
  const char* remark = "";       // of load("home"); "": none
  const char* passed_over = "";  // of newest(); "": nothing
  bool whole = true;             // all that was written is found
};

void touch(const fs::path& file, const std::string& text = "strange") { std::ofstream(file) << text; }
void makePipe(const fs::path& file) { ASSERT_EQ(mkfifo(file.c_str(), 0600), 0); }
void makeSocket(const fs::path& file) { ASSERT_EQ(mknod(file.c_str(), S_IFSOCK | 0600, 0), 0); }
void replace(const fs::path& file, void (*put)(const fs::path&)) {
  fs::remove_all(file);
  put(file);
}
void grow(const fs::path& file) { fs::resize_file(file, 40'000'000'000); }

const Strange kStrange[] = {
    // Beside the map.
    {"a file", [](const fs::path& maps) { touch(maps / "map-2"); }},
    {"an empty folder", [](const fs::path& maps) { fs::create_directories(maps / "map-2"); }},
    {"a map's empty numbered folder", [](const fs::path& maps) { fs::create_directories(maps / "map-2/000001"); }, "",
     "map-2: no generation in it has a manifest that can be read"},
    {"a map of other numbers", [](const fs::path& maps) { fs::create_directories(maps / "map-2/2024"); }},
    {"a number as a map", [](const fs::path& maps) { fs::create_directories(maps / "000003"); }},
    {"a loop of links", [](const fs::path& maps) { fs::create_symlink("map-2", maps / "map-2"); }},
    {"a link to nowhere", [](const fs::path& maps) { fs::create_symlink("nowhere", maps / "map-2"); }},
    {"a link to the folder itself", [](const fs::path& maps) { fs::create_directory_symlink(".", maps / "map-2"); }},
    {"a pipe", [](const fs::path& maps) { makePipe(maps / "map-2"); }},
    {"a socket", [](const fs::path& maps) { makeSocket(maps / "map-2"); }},
    {"names that are none",
     [](const fs::path& maps) {
       for (const char* name : {"my map", ".hidden", "lost+found", "caf\xE9", "a\nb"}) {
         fs::create_directories(maps / name / "000009");
       }
     }},
    {"a manifest that is a pipe",
     [](const fs::path& maps) {
       fs::create_directories(maps / "map-2/000001");
       makePipe(maps / "map-2/000001/MANIFEST");
     },
     "", "map-2: no generation"},
    {"a manifest of nonsense",
     [](const fs::path& maps) {
       fs::create_directories(maps / "map-2/000001");
       touch(maps / "map-2/000001/MANIFEST");
     },
     "", "map-2: no generation"},
    {"journals alone",
     [](const fs::path& maps) {
       fs::create_directories(maps / "map-2");
       fs::copy(maps / "home/000002.journal", maps / "map-2/000002.journal");
     }},
    // In the map, beside its generations.
    {"an empty numbered folder behind the newest",
     [](const fs::path& maps) { fs::create_directories(maps / "home/000003"); },
     "000003/MANIFEST: cannot read: No such file or directory; used generation 2 instead"},
    {"a numbered folder of something else",
     [](const fs::path& maps) {
       fs::create_directories(maps / "home/000003");
       touch(maps / "home/000003/photo.jpg");
     },
     "used generation 2 instead"},
    {"the highest number", [](const fs::path& maps) { fs::create_directories(maps / "home/999999999"); },
     "used generation 2 instead"},
    {"numbers that are none",
     [](const fs::path& maps) {
       for (const char* name : {"0", "00000", "000000", "0000002", "2", "99999999999999999999", "-00001", "000002 "}) {
         fs::create_directories(maps / "home" / name);
       }
     }},
    {"a file with the next number", [](const fs::path& maps) { touch(maps / "home/000003"); }},
    {"a pipe with the next number", [](const fs::path& maps) { makePipe(maps / "home/000003"); }},
    {"a link to nowhere with the next number",
     [](const fs::path& maps) { fs::create_symlink("nowhere", maps / "home/000003"); }},
    {"a loop of links with the next number",
     [](const fs::path& maps) { fs::create_symlink("000003", maps / "home/000003"); }},
    {"a folder as the next journal",
     [](const fs::path& maps) { fs::create_directories(maps / "home/000003.journal/in the way"); },
     "000003.journal: cannot read: it is a folder, not a file; used the 0 records before that"},
    {"a pipe as the next journal", [](const fs::path& maps) { makePipe(maps / "home/000003.journal"); },
     "000003.journal: cannot read: it is a pipe"},
    {"a socket as the next journal", [](const fs::path& maps) { makeSocket(maps / "home/000003.journal"); },
     "000003.journal: cannot read: it is a socket"},
    {"a loop of links as the next journal",
     [](const fs::path& maps) { fs::create_symlink("000003.journal", maps / "home/000003.journal"); },
     "000003.journal: cannot read: Too many levels of symbolic links"},
    {"the journal of a map that is not there", [](const fs::path& maps) { touch(maps / "home/000007.journal"); },
     "000007.journal: cut off behind record 0"},
    {"journals of other numbers",
     [](const fs::path& maps) {
       for (const char* name :
            {"3.journal", "journal", ".journal", "99999999999999999999.journal", "000003.journal.old"})
         fs::create_directories(maps / "home" / name);
     }},
    {"a half-written checkpoint", [](const fs::path& maps) { fs::copy(maps / "home/000002", maps / "home/writing"); }},
    {"a file in place of one", [](const fs::path& maps) { touch(maps / "home/writing"); }},
    {"a loop of links in place of one",
     [](const fs::path& maps) { fs::create_symlink("writing", maps / "home/writing"); }},
    {"copies of generations",
     [](const fs::path& maps) {
       for (const char* name : {"000002 (copy)", "000002.bak", "old"})
         fs::copy(maps / "home/000002", maps / "home" / name);
     }},
    {"a generation that is a link elsewhere",
     [](const fs::path& maps) {
       fs::rename(maps / "home/000002", maps.parent_path() / "elsewhere");
       fs::create_directory_symlink(maps.parent_path() / "elsewhere", maps / "home/000002");
     }},
    // In the place of what the map needs; the generation before and its journal have all of it.
    {"a newest generation that is a file",
     [](const fs::path& maps) { replace(maps / "home/000002", [](const fs::path& f) { touch(f); }); }},
    {"a newest generation that is a loop of links",
     [](const fs::path& maps) {
       replace(maps / "home/000002", [](const fs::path& f) { fs::create_symlink(f.filename(), f); });
     }},
    {"keyframes that are a pipe", [](const fs::path& maps) { replace(maps / "home/000002/keyframes.bin", makePipe); },
     "keyframes.bin: cannot read: it is a pipe, not a file; used generation 1 instead"},
    {"keyframes that are a folder",
     [](const fs::path& maps) {
       replace(maps / "home/000002/keyframes.bin", [](const fs::path& f) { fs::create_directory(f); });
     },
     "keyframes.bin: cannot read: it is a folder"},
    {"keyframes of 40 GB", [](const fs::path& maps) { grow(maps / "home/000002/keyframes.bin"); },
     "keyframes.bin: cannot read: it has 40000000000 bytes"},
    {"a manifest of 40 GB", [](const fs::path& maps) { grow(maps / "home/000002/MANIFEST"); },
     "MANIFEST: cannot read: it has 40000000000 bytes"},
    {"a manifest that is a pipe", [](const fs::path& maps) { replace(maps / "home/000002/MANIFEST", makePipe); },
     "MANIFEST: cannot read: it is a pipe"},
    {"a manifest that is a loop of links",
     [](const fs::path& maps) {
       replace(maps / "home/000002/MANIFEST", [](const fs::path& f) { fs::create_symlink(f.filename(), f); });
     },
     "MANIFEST: cannot read: Too many levels"},
    {"a state that no disk gives",
     [](const fs::path& maps) {
       replace(maps / "home/000002/state.toml", [](const fs::path& f) { fs::create_symlink("/proc/self/mem", f); });
     },
     "state.toml: cannot read: Input/output error; used generation 1 instead"},
    {"a grid that is a pipe", [](const fs::path& maps) { replace(maps / "home/000002/grid.bin", makePipe); },
     "grid.bin: cannot read: it is a pipe, not a file; the grid is drawn anew from the keyframes"},
    {"depth of 40 GB", [](const fs::path& maps) { grow(maps / "home/000002/depth.bin"); },
     "depth.bin: cannot read: it has 40000000000 bytes"},
    // In the place of the newest journal: what it held is lost, and said.
    {"a journal that no disk gives",
     [](const fs::path& maps) {
       replace(maps / "home/000002.journal", [](const fs::path& f) { fs::create_symlink("/proc/self/mem", f); });
     },
     "000002.journal: cannot read: Input/output error; used the 0 records before that", "", false},
    {"a journal that is a folder",
     [](const fs::path& maps) {
       replace(maps / "home/000002.journal", [](const fs::path& f) { fs::create_directory(f); });
     },
     "000002.journal: cannot read: it is a folder", "", false},
    {"a journal that is a pipe", [](const fs::path& maps) { replace(maps / "home/000002.journal", makePipe); },
     "000002.journal: cannot read: it is a pipe", "", false},
    {"a journal of 40 GB", [](const fs::path& maps) { grow(maps / "home/000002.journal"); },
     "000002.journal: cut off behind record 3"},
};

TEST(MapStore, WhatLiesBesideAMapLosesNothingOfIt) {
  static_assert(std::size(kStrange) >= 38);
  for (const Strange& strange : kStrange) {
    SCOPED_TRACE(strange.what);
    const Folder folder;
    fs::create_directories(folder / "maps");
    Drive drive(folder / "maps");
    strange.put(folder / "maps");
    std::vector<std::string> passed_over;
    EXPECT_EQ(MapStore::newest(folder / "maps", &passed_over), "home");
    EXPECT_EQ(passed_over.size(), *strange.passed_over == '\0' ? 0U : 1U);
    for (const std::string& words : passed_over) EXPECT_THAT(words, HasSubstr(strange.passed_over));
    LoadedMap loaded;
    ASSERT_NO_THROW(loaded = MapStore::load(folder / "maps", "home", kGrid));
    EXPECT_EQ(drive.find(loaded.state), strange.whole ? kLast : kSecond);
    EXPECT_EQ(loaded.remarks.size(), *strange.remark == '\0' ? 0U : 1U);
    for (const std::string& remark : loaded.remarks) {
      EXPECT_THAT(remark, HasSubstr(strange.remark));
      EXPECT_TRUE(oneSentence(remark));
    }
    const auto listed = MapStore::list(folder / "maps");
    const auto home = std::find_if(listed.begin(), listed.end(), [](const auto& map) { return map.name == "home"; });
    ASSERT_NE(home, listed.end());
    EXPECT_EQ(home->generation, loaded.generation);

    // Who goes on in it stores it, again and again, and finds it.
    MapStore next(folder / "maps", "home");
    for (int i = 0; i < 3; ++i) {
      drive.changing.addKeyframe(true);
      drive.changing.touch();
      ASSERT_NO_THROW(next.checkpoint(drive.changing.map));
      EXPECT_EQ(next.leftover(), "");
      const LoadedMap again = MapStore::load(folder / "maps", "home", kGrid);
      EXPECT_EQ(differenceOf(again.state, drive.changing.map), "");
      EXPECT_EQ(again.generation, next.generation());
      EXPECT_EQ(MapStore::newest(folder / "maps"), "home");
    }
  }
}

TEST(MapStore, AnOlderGenerationThatCannotBeRemovedIsReportedAndNoFailure) {
  const Folder folder;
  Drive drive(folder / "");
  {
    const test::Irremovable stays(folder / "home/000001/keyframes.bin");
    if (!stays.holds()) GTEST_SKIP() << "root may remove any file of this file system";
    for (int i = 0; i < 3; ++i) {
      drive.changing.addKeyframe(true);
      ASSERT_NO_THROW(drive.checkpoint());
      EXPECT_THAT(drive.store.leftover(), AllOf(HasSubstr("home/000001: cannot remove: "), HasSubstr("ermi")));
      drive.changing.addKeyframe(true);
      drive.append();
      const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
      EXPECT_EQ(differenceOf(loaded.state, drive.changing.map), "");
      EXPECT_THAT(loaded.remarks, IsEmpty());
    }
  }
  drive.checkpoint();
  EXPECT_EQ(drive.store.leftover(), "");
  EXPECT_FALSE(fs::exists(folder / "home/000001"));
}

TEST(MapStore, AnUnfinishedCheckpointThatCannotBeRemovedIsInNobodysWay) {
  const Folder folder;
  Drive drive(folder / "");
  fs::create_directory(folder / "home/writing");
  folder.write("home/writing/keyframes.bin", "half");
  const test::Irremovable stays(folder / "home/writing/keyframes.bin");
  if (!stays.holds()) GTEST_SKIP() << "root may remove any file of this file system";
  for (int i = 0; i < 3; ++i) ASSERT_NO_THROW(drive.checkpoint());
  EXPECT_EQ(MapStore::load(folder / "", "home", kGrid).generation, 5);
  EXPECT_FALSE(fs::exists(folder / "home/writing-2"));
}

TEST(MapStore, StoresNothingThatItWouldNotReadAndKeepsWhatItHas) {
  const double infinite = std::numeric_limits<double>::infinity();
  const std::function<void(MapState&)> kBad[] = {
      [&](MapState& map) {
        map.keyframes.graph().setPose(1, {0.0, infinite, 0.0});
      },
      [&](MapState& map) { map.T_map_base.x = infinite; },
      [&](MapState& map) { map.utime = -1; },
      [&](MapState& map) {
        map.views = {test::viewFrom(1, map.keyframes.pose(1))};
        map.views[0].T_keyframe_base.theta = infinite;
      },
      [&](MapState& map) { map.grid = OccupancyGrid({.resolution = infinite}); },
  };
  for (const auto& spoil : kBad) {
    const Folder folder;
    Drive drive(folder / "");
    MapState bad = drive.changing.copy();
    spoil(bad);
    for (int i = 0; i < 3; ++i) {  // as often as there are generations to bury
      EXPECT_THROW(drive.store.checkpoint(bad), std::runtime_error);
    }
    EXPECT_FALSE(fs::exists(folder / "home/writing"));
    EXPECT_EQ(drive.find(MapStore::load(folder / "", "home", kGrid).state), kLast);
    drive.changing.addKeyframe(true);
    drive.append();
    const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
    EXPECT_EQ(differenceOf(loaded.state, drive.changing.map), "") << "the journal goes on";
    EXPECT_EQ(loaded.generation, 2);
  }
}

TEST(MapStore, ACheckpointDoesWithoutTheJournalBeforeItWhereThatCannotHoldWhatChanged) {
  const Folder folder;
  Drive drive(folder / "");
  drive.changing.addKeyframe(true);
  drive.store.checkpoint(drive.changing.map, std::vector<MapView>{test::viewFrom(99, {})});  // of no keyframe
  const LoadedMap loaded = MapStore::load(folder / "", "home", kGrid);
  EXPECT_EQ(differenceOf(loaded.state, drive.changing.map), "");
  EXPECT_EQ(loaded.generation, 3);
  damage(folder / "home/000003/keyframes.bin");
  EXPECT_EQ(drive.find(MapStore::load(folder / "", "home", kGrid).state), kLast) << "as far as the journal went";
}

TEST(MapStore, WaitsForTheDiskBeforeAGenerationHasItsNumber) {
  const Folder folder;
  Drive drive(folder / "");
  test::syncLog().clear();
  drive.checkpoint();
  const std::string map = folder / "home/";
  EXPECT_THAT(test::syncLog(),
              ElementsAre(map + "writing/keyframes.bin", map + "writing/graph.bin", map + "writing/grid.bin",
                          map + "writing/state.toml", map + "writing/depth.bin", map + "writing/MANIFEST",
                          map + "writing", map + "000002.journal", map + "000003.journal", folder / "home"));
}

TEST(OpenMap, TakesAFolderOrAPicture) {
  const Folder folder;
  const Drive drive(folder / "");
  for (const fs::path& path : {folder / "home", folder / "home/", folder / "./home"}) {
    EXPECT_EQ(drive.find(openMap(path, kGrid).state), kLast) << path;
  }
  writeMapFiles(folder / "picture", renderMap(drive.changing.map.grid), {});
  EXPECT_EQ(openMap(folder / "picture.yaml", kGrid).state.kind, MapKind::kFloorPlan);
  EXPECT_TRUE(oneSentence(refusalOf([&] { openMap(folder / "missing.yaml", kGrid); })));
  EXPECT_TRUE(oneSentence(refusalOf([&] { openMap(folder / "missing", kGrid); })));
}

}  // namespace
}  // namespace slam::map_store_test
