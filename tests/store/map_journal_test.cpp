// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_journal.hpp"

#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "support/file_size_limit.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::map_journal_test {
namespace {

using test::ChangingMap;
using test::contentOf;
using test::differenceOf;
using test::Folder;

/// What may happen to a map between two writings.
const std::vector<std::function<void(ChangingMap&)>> kChanges = {
    [](ChangingMap& m) { m.addKeyframe(true); },
    [](ChangingMap& m) { m.touch(); },
    [](ChangingMap& m) {
      m.addKeyframe(true);
      m.addKeyframe(true);
      m.closeLoop(1, 5);
      m.move();
    },
    [](ChangingMap& m) { m.map.keyframes.graph().revoke(3); },
    [](ChangingMap& m) { m.addKeyframe(false), m.addKeyframe(false); },
    [](ChangingMap& m) { m.map.keyframes.graph().restore(3); },
    [](ChangingMap& m) {  // found, and lost again before it was written
      m.map.in_map[7] = m.map.in_map[8] = 1;
      m.addKeyframe(false);
      m.move();
    },
    [](ChangingMap& m) { m.map.in_map[9] = 1, m.touch(); },
};

/// A journal of these changes and the map as it was at its begin and after each record.
struct Written {
  explicit Written(const std::filesystem::path& file) {
    ChangingMap changing;
    MapJournal journal(file, changing.map);
    sizes.push_back(std::filesystem::file_size(file));
    states.push_back(changing.copy());
    for (const auto& change : kChanges) {
      change(changing);
      journal.append(changing.map);
      sizes.push_back(std::filesystem::file_size(file));
      states.push_back(changing.copy());
    }
    journal.sync();
  }
  MapState base() const { return ChangingMap().copy(); }
  std::vector<std::uintmax_t> sizes;
  std::vector<MapState> states;
};

TEST(MapJournal, LeadsFromTheCheckpointToTheMap) {
  const Folder folder;
  const Written written(folder / "journal");
  MapState map = written.base();
  const auto replayed = MapJournal::replay(folder / "journal", map);
  EXPECT_EQ(differenceOf(map, written.states.back()), "");
  EXPECT_FALSE(replayed.torn);
  EXPECT_TRUE(replayed.moved);
  EXPECT_EQ(replayed.records, static_cast<int>(kChanges.size()) + 1);
}

TEST(MapJournal, CutAnywhereItYieldsAllThatWasWrittenBefore) {
  const Folder folder;
  const Written written(folder / "journal");
  const std::string whole = contentOf(folder / "journal");
  std::size_t intact = 0;
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    while (intact < written.sizes.size() && written.sizes[intact] <= size) ++intact;
    folder.write("cut", whole.substr(0, size));
    MapState map = written.base();
    const auto replayed = MapJournal::replay(folder / "cut", map);
    ASSERT_EQ(differenceOf(map, written.states[intact == 0 ? 0 : intact - 1]), "") << size;
    ASSERT_EQ(replayed.records, static_cast<int>(intact)) << size;
    ASSERT_EQ(replayed.torn, size != 0 && (intact == 0 || size != written.sizes[intact - 1])) << size;
  }
}

TEST(MapJournal, OneFlippedByteCutsItOffThere) {
  const Folder folder;
  const Written written(folder / "journal");
  const std::string whole = contentOf(folder / "journal");
  std::size_t record = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    while (written.sizes[record] <= at) ++record;
    for (const char flip : {'\x01', '\x40', '\xFF'}) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ flip);
      folder.write("damaged", damaged);
      MapState map = written.base();
      const auto replayed = MapJournal::replay(folder / "damaged", map);
      ASSERT_EQ(differenceOf(map, written.states[record == 0 ? 0 : record - 1]), "") << at;
      ASSERT_TRUE(replayed.torn) << at;
      ASSERT_EQ(replayed.records, static_cast<int>(record)) << at;
    }
  }
}

TEST(MapJournal, TakesNothingThatStandsBehindDamage) {
  const Folder folder;
  const Written written(folder / "journal");
  std::string content = contentOf(folder / "journal");
  content.insert(written.sizes[3], "x");
  folder.write("damaged", content);
  MapState map = written.base();
  EXPECT_EQ(MapJournal::replay(folder / "damaged", map).records, 4);
  EXPECT_EQ(differenceOf(map, written.states[3]), "");
}

TEST(MapJournal, ContinuesNoOtherMap) {
  const Folder folder;
  const Written written(folder / "journal");
  ChangingMap longer(5), moved, undone;
  moved.move();
  undone.map.keyframes.graph().revoke(1);
  for (const ChangingMap* other : {&longer, &moved, &undone}) {
    MapState map = other->copy();
    const auto replayed = MapJournal::replay(folder / "journal", map);
    EXPECT_EQ(replayed.records, 0);
    EXPECT_TRUE(replayed.torn);
    EXPECT_EQ(differenceOf(map, other->map), "");
  }
}

TEST(MapJournal, LeavesItToTheGridWhatItShows) {
  const Folder folder;
  ChangingMap changing;
  MapJournal journal(folder / "journal", changing.map);
  changing.addKeyframe(true);
  changing.touch();
  changing.map.grid_keyframes = changing.map.keyframes.size();
  journal.append(changing.map);
  MapState map = ChangingMap().copy();
  EXPECT_FALSE(MapJournal::replay(folder / "journal", map).moved);
  EXPECT_EQ(map.keyframes.size(), 5);
  EXPECT_EQ(map.grid_keyframes, 4) << "the stored grid does not show the new one";
}

TEST(MapJournal, HasTheGridDrawnAnewForASegmentThatWasFound) {
  const Folder folder;
  ChangingMap changing;
  changing.addKeyframe(false);
  MapState map = changing.copy();
  MapJournal journal(folder / "journal", changing.map);
  changing.map.in_map[4] = 1;
  journal.append(changing.map);
  EXPECT_TRUE(MapJournal::replay(folder / "journal", map).moved);
  EXPECT_EQ(differenceOf(map, changing.map), "");
}

TEST(MapJournal, WritesNothingWhereNothingChanged) {
  const Folder folder;
  ChangingMap changing;
  MapJournal journal(folder / "journal", changing.map);
  changing.addKeyframe(true);
  journal.append(changing.map);
  const auto size = std::filesystem::file_size(folder / "journal");
  journal.append(changing.map);
  EXPECT_EQ(std::filesystem::file_size(folder / "journal"), size);
}

TEST(MapJournal, WritesLaterWhatTheFullDiskRefused) {
  const Folder folder;
  ChangingMap changing;
  MapJournal journal(folder / "journal", changing.map);
  changing.addKeyframe(true);
  journal.append(changing.map);
  {
    const test::FileSizeLimit limit(std::filesystem::file_size(folder / "journal") + 50);
    changing.addKeyframe(false);
    changing.closeLoop(0, 5);
    EXPECT_THROW(journal.append(changing.map), std::runtime_error);
    changing.map.in_map[5] = 1;
    changing.move();
    EXPECT_THROW(journal.append(changing.map), std::runtime_error);
  }
  changing.addKeyframe(true);
  journal.append(changing.map);
  MapState map = ChangingMap().copy();
  EXPECT_FALSE(MapJournal::replay(folder / "journal", map).torn);
  EXPECT_EQ(differenceOf(map, changing.map), "");
}

TEST(MapJournal, HoldsWhatTheDepthCameraSaw) {
  const Folder folder;
  ChangingMap changing;
  MapState map = changing.copy(), other = changing.copy();
  MapJournal journal(folder / "journal", changing.map);
  changing.addKeyframe(true);
  const std::vector<MapView> seen = {test::viewFrom(1, changing.map.keyframes.pose(1)),
                                     test::viewFrom(4, changing.map.keyframes.pose(4))};  // of the new keyframe
  journal.append(changing.map, seen);
  const auto whole = std::filesystem::file_size(folder / "journal");
  EXPECT_THROW(journal.append(changing.map, std::vector<MapView>{test::viewFrom(5, {})}), UnreadableMap)
      << "of one that there is not";
  journal.sync();
  const auto replayed = MapJournal::replay(folder / "journal", map);
  EXPECT_FALSE(replayed.torn);
  EXPECT_EQ(replayed.records, 2);
  ASSERT_EQ(map.views.size(), 2U);
  EXPECT_EQ(replayed.seen.size(), 2U);
  EXPECT_EQ(map.views[1].keyframe, 4);
  EXPECT_EQ(map.views[1].view->beams.size(), 2U);

  std::filesystem::resize_file(folder / "journal", whole - 1);
  EXPECT_TRUE(MapJournal::replay(folder / "journal", other).torn);
  EXPECT_TRUE(other.views.empty()) << "all of a record or nothing";
}

TEST(MapJournal, ReportsThatTheDiskDoesNotGiveIt) {
  const Folder folder;
  MapState map = ChangingMap().copy();
  for (const auto& [file, words] : {std::pair<std::string, const char*>{"/proc/self/mem", "Input/output error"},
                                    {folder / "", "it is a folder"},
                                    {folder / "missing", "No such file"}}) {
    const auto replayed = MapJournal::replay(file, map);
    EXPECT_TRUE(replayed.torn) << file;
    EXPECT_EQ(replayed.records, 0) << file;
    EXPECT_THAT(replayed.unread, testing::HasSubstr(words));
  }
  EXPECT_EQ(differenceOf(map, ChangingMap().map), "");
}

TEST(MapJournal, TakesNoMemoryForWhatIsNotThere) {
  const Folder folder;
  const Written written(folder / "journal");
  // A record that claims 200 MB, then 40 GB without blocks on the disk.
  const std::string claim("SLMJ\x00\x00\x00\x0C\x00\x00\x00\x00", 12);
  folder.write("claim", contentOf(folder / "journal") + claim);
  std::filesystem::copy(folder / "journal", folder / "sparse");
  std::filesystem::resize_file(folder / "sparse", 40'000'000'000);
  for (const char* name : {"claim", "sparse"}) {
    MapState map = written.base();
    const auto replayed = MapJournal::replay(folder / name, map);
    EXPECT_EQ(differenceOf(map, written.states.back()), "") << name;
    EXPECT_TRUE(replayed.torn) << name;
    EXPECT_EQ(replayed.unread, "") << name;
  }
}

TEST(MapJournal, WritesNothingThatItWouldNotRead) {
  const Folder folder;
  const double infinite = std::numeric_limits<double>::infinity();
  const std::function<void(ChangingMap&)> kBad[] = {
      [&](ChangingMap& m) {
        m.map.keyframes.graph().setPose(1, {infinite, 0.0, 0.0});
      },
      [&](ChangingMap& m) { m.map.T_map_base.y = infinite; },
      [&](ChangingMap& m) { m.map.gyro_bias = -infinite; },
      [&](ChangingMap& m) {
        auto scan = std::make_shared<StoredScan>();
        scan->points.push_back({.x = static_cast<float>(infinite), .y = 0.0F});
        m.map.keyframes.add(scan, {});
        m.map.in_map.push_back(1);
      },
      [&](ChangingMap& m) {
        m.map.keyframes.graph().addEdge({.from = 0, .to = 1, .T_from_to = {infinite, 0.0, 0.0}});
      },
  };
  for (const auto& spoil : kBad) {
    ChangingMap changing;
    const MapState base = changing.copy();
    MapJournal journal(folder / "journal", base);
    changing.addKeyframe(true);
    const MapState good = changing.copy();
    journal.append(good);
    const std::string before = contentOf(folder / "journal");
    spoil(changing);
    EXPECT_THROW(journal.append(changing.map), std::runtime_error);
    EXPECT_EQ(contentOf(folder / "journal"), before) << "a record that is refused hides those behind it";
    MapState again = ChangingMap().copy();
    EXPECT_FALSE(MapJournal::replay(folder / "journal", again).torn);
    EXPECT_EQ(differenceOf(again, good), "");
  }
}

}  // namespace
}  // namespace slam::map_journal_test
