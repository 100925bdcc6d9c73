// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/maps/map_export.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "store/map_store.hpp"
#include "support/simulated/mapped_drive.hpp"
#include "tools/files.hpp"
#include "tools/slamctl/maps/map_drawing.hpp"
#include "tools/slamctl/maps/stored_map.hpp"
#include "tools/unzip.hpp"

namespace slam {
namespace {

using testing::HasSubstr;

struct ExportedMap : testing::Test {
  ExportedMap() {
    MapStore(folder / "", "a").checkpoint(drive.map);
    EditRequest dock;
    dock.kind = EditKind::kPlace;
    dock.name = "dock <1> & more";
    dock.points = {drive.map.keyframes.pose(5).translation()};
    const EditCommand command{.kind = EditCommand::kAdd, .request = dock, .utime = 1};
    StoredMap{folder / "", "a", test::smallGrid()}.edit({&command, 1});
  }
  MapExport exported(const char* prefix) const {
    return {.map = folder / "a", .prefix = folder / prefix, .grid = test::smallGrid()};
  }

  test::MappedDrive drive = test::mapped(test::ringCorridor(), test::alongRing(0.0, 10.0), 1);
  test::Folder folder;
  std::vector<std::string> remarks;
};

TEST_F(ExportedMap, IsOneZipOfAllItsForms) {
  exported("out").writeAll(&remarks);
  const auto entries = test::unzipped(folder / "out.zip");
  std::vector<std::string> names;
  for (const auto& [name, content] : entries) {
    names.push_back(name);
    EXPECT_FALSE(content.empty()) << name;
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre("out.yaml", "out.pgm", "out.png", "out-keepout.yaml",
                                                   "out-keepout.pgm", "out.geojson", "out.tum", "out.svg", "out.ply"));
  EXPECT_THAT(entries.at("out.yaml"), HasSubstr("image: out.pgm"));
  EXPECT_THAT(entries.at("out.geojson"), HasSubstr("dock"));
  const std::string& path = entries.at("out.tum");
  EXPECT_EQ(std::count(path.begin(), path.end(), '\n'), drive.map.keyframes.size());
  EXPECT_FALSE(std::filesystem::exists(folder / "out.yaml"));
  for (const auto& entry : std::filesystem::directory_iterator(folder / ""))
    EXPECT_THAT(entry.path().filename().string(), testing::AnyOf("a", "out.zip")) << "nothing else is left";
}

TEST_F(ExportedMap, OverwritesNoZip) {
  exported("out").writeAll(&remarks);
  const std::string before = test::contentOf(folder / "out.zip");
  EXPECT_THAT(test::refusalOf([&] { exported("out").writeAll(&remarks); }), HasSubstr("is there already"));
  EXPECT_EQ(test::contentOf(folder / "out.zip"), before);
}

TEST_F(ExportedMap, LeavesNoZipWhereThereIsNoMap) {
  MapExport none = exported("out");
  none.map = folder / "none";
  EXPECT_NE(test::refusalOf([&] { none.writeAll(&remarks); }), "");
  EXPECT_FALSE(std::filesystem::exists(folder / "out.zip"));
}

TEST_F(ExportedMap, HasItsNamesInTheDrawing) {
  const MapState map = MapStore::load(folder / "", "a", test::smallGrid()).state;
  const std::string svg = mapSvg(map, renderMap(map.grid), {});
  EXPECT_THAT(svg, HasSubstr("dock &lt;1&gt; &amp; more"));
  EXPECT_THAT(svg, HasSubstr("class=\"walls\" fill=\"black\" d=\"M"));
  EXPECT_THAT(svg, testing::EndsWith("</svg>\n"));
}

TEST_F(ExportedMap, HasAllPointsInThePly) {
  std::size_t points = 0;
  for (int id = 0; id < drive.map.keyframes.size(); ++id) points += drive.map.keyframes.scan(id)->points.size();
  const std::string ply = pointsPly(drive.map);
  EXPECT_THAT(ply, HasSubstr("element vertex " + std::to_string(points) + "\n"));
  const std::string end = "end_header\n";
  EXPECT_EQ(ply.size() - ply.find(end) - end.size(), 12 * points);
}

}  // namespace
}  // namespace slam
