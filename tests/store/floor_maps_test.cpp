// SPDX-License-Identifier: BSD-3-Clause
#include "store/floor_maps.hpp"

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>

#include "store/map_store.hpp"
#include "support/stored_map.hpp"
#include "tools/files.hpp"

namespace slam::test::floor_maps_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(FloorMaps, AreListedByNameOrAllOfTheFolder) {
  const Folder folder;
  const std::filesystem::path maps = folder / "maps";
  std::filesystem::create_directories(maps);
  for (const char* name : {"b", "a", ".deleted"}) std::filesystem::create_directories(maps / name);
  std::ofstream(maps / "file") << "no map";
  EXPECT_THAT(floorNames(maps, "*"), ElementsAre("a", "b"));
  EXPECT_THAT(floorNames(maps, " first, ground  first "), ElementsAre("first", "ground"));
  EXPECT_TRUE(floorNames(maps, "").empty());
  EXPECT_TRUE(floorNames(folder / "nowhere", "*").empty());
}

TEST(FloorMaps, AreLoadedButForThePresentOneAndThoseThatCannotBeUsed) {
  const Folder folder;
  const std::filesystem::path maps = folder / "maps";
  std::filesystem::create_directories(maps);
  const ChangingMap made;
  const MapState& map = made.map;
  for (const char* name : {"ground", "first"}) MapStore(maps, name).checkpoint(map);
  LidarModel lidar;
  lidar.T_base_lidar = map.T_base_lidar;
  lidar.range_max = map.range_max;
  std::vector<std::string> remarks;
  const Floors floors = loadFloors(maps, "* missing", "ground", lidar, &remarks);
  EXPECT_EQ(floors.present, "ground");
  ASSERT_EQ(floors.others.size(), 1U);
  EXPECT_EQ(floors.others[0]->name, "first");
  EXPECT_EQ(floors.others[0]->keyframes.size(), map.keyframes.size());
  EXPECT_THAT(remarks, ElementsAre(HasSubstr("missing")));
  lidar.T_base_lidar.x += 0.5;
  remarks.clear();
  EXPECT_TRUE(loadFloors(maps, "first", "ground", lidar, &remarks).others.empty());
  EXPECT_THAT(remarks, ElementsAre(HasSubstr("a lost robot is not searched in it")));
}

}  // namespace
}  // namespace slam::test::floor_maps_test
