// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/map_description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <stdexcept>
#include <string>

namespace slam::map_description_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Mode = MapDescription::Mode;

constexpr char kYaml[] =
    "image: map.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1, -2, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
    "free_thresh: 0.196\n";

/// kYaml with something else in place of a part of it.
std::string with(const std::string& part, const std::string& other) {
  std::string yaml = kYaml;
  return yaml.replace(yaml.find(part), part.size(), other);
}

std::string errorOf(const std::string& yaml) {
  try {
    parseMapDescription(yaml);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

void expectDescription(const std::string& yaml) {
  const MapDescription read = parseMapDescription(yaml);
  EXPECT_EQ(read.image, "map.pgm") << yaml;
  EXPECT_EQ(read.resolution, 0.05) << yaml;
  EXPECT_EQ(read.T_map_picture, (Pose2{-1.0, -2.0, 0.0})) << yaml;
  EXPECT_EQ(read.mode, Mode::kTrinary) << yaml;
  EXPECT_FALSE(read.negate) << yaml;
  EXPECT_EQ(read.occupied_threshold, 0.65) << yaml;
  EXPECT_EQ(read.free_threshold, 0.196) << yaml;
}

TEST(MapDescription, IsReadHoweverYamlWritesIt) {
  expectDescription(kYaml);
  expectDescription(with("[-1, -2, 0]", "\n- -1\n- -2.0\n- 0.0"));
  expectDescription(with("[-1, -2, 0]", "\n  - -1\n  - -2\n  - 0"));
  expectDescription(with("[-1, -2, 0]", "[-1.0,\n  -2.0,\n  0.0]"));
  expectDescription(with("map.pgm", "\"map.pgm\"  # beside this file"));
  expectDescription(with("map.pgm", "'map.pgm'"));
  expectDescription(with("0.05", "5e-2"));
  expectDescription(with("negate: 0", "negate: false"));
  expectDescription(with("negate: 0\n", ""));
  expectDescription(with("mode: trinary\n", ""));
  expectDescription(with("occupied_thresh: 0.65\nfree_thresh: 0.196\n", "by: somebody\n"));
  expectDescription("---\n" + std::string(kYaml) + "...\n");
  expectDescription("{image: map.pgm, resolution: 0.05, origin: [-1, -2, 0], negate: 0}\n");
  std::string dos = kYaml;
  for (std::size_t at = 0; (at = dos.find('\n', at)) != std::string::npos; at += 2) dos.replace(at, 1, "\r\n");
  expectDescription(dos);
}

TEST(MapDescription, HasYawModeAndNegation) {
  EXPECT_EQ(parseMapDescription(with("[-1, -2, 0]", "[1, 2, -0.5]")).T_map_picture, (Pose2{1.0, 2.0, -0.5}));
  EXPECT_EQ(parseMapDescription(with("trinary", "scale")).mode, Mode::kScale);
  EXPECT_EQ(parseMapDescription(with("trinary", "\"raw\"")).mode, Mode::kRaw);
  for (const char* const yes : {"1", "true", "yes"})
    EXPECT_TRUE(parseMapDescription(with("negate: 0", std::string("negate: ") + yes)).negate) << yes;
}

TEST(MapDescription, NamesTheKeyThatIsWrongAndItsValue) {
  for (const char* const key : {"image", "resolution", "origin"})
    EXPECT_THAT(errorOf(with(key, std::string("un") + key)), AllOf(HasSubstr("has no key"), HasSubstr(key)));
  EXPECT_THAT(errorOf(with("map.pgm", "[a, b]")), HasSubstr("image: a list or map is no name"));
  EXPECT_THAT(errorOf(with("map.pgm", "''")), HasSubstr("image: '' is no name"));
  EXPECT_THAT(errorOf(with("0.05", "5 cm")), HasSubstr("resolution: '5 cm' is not a number"));
  EXPECT_THAT(errorOf(with("0.05", "")), HasSubstr("resolution: nothing is not a number"));
  for (const char* const number : {".nan", ".inf", "-.inf"})
    EXPECT_THAT(errorOf(with("0.05", number)), HasSubstr("is no finite number")) << number;
  EXPECT_THAT(errorOf(with("0.05", "1e999")), HasSubstr("is not a number"));
  for (const char* const origin : {"[-1, -2]", "[-1, -2, 0, 0]", "0", "{x: 1, y: 2, yaw: 0}"})
    EXPECT_THAT(errorOf(with("[-1, -2, 0]", origin)), HasSubstr("list of three numbers, [x, y, yaw]")) << origin;
  EXPECT_THAT(errorOf(with("[-1, -2, 0]", "[-1, [2], 0]")), HasSubstr("origin: a list or map is not a number"));
  EXPECT_THAT(errorOf(with("trinary", "binary")), HasSubstr("mode: 'binary' is not trinary, scale or raw"));
  EXPECT_THAT(errorOf(with("negate: 0", "negate: 2")), HasSubstr("negate: '2' is not 0, 1"));
  EXPECT_THAT(errorOf(with("negate: 0", "negate: maybe")), HasSubstr("negate: 'maybe' is not 0, 1"));
  EXPECT_THAT(errorOf(with("0.65", "65")), HasSubstr("occupied_thresh: '65' is not from 0 to 1"));
  EXPECT_THAT(errorOf(with("0.196", "0.7")), HasSubstr("free_thresh is above occupied_thresh"));
}

TEST(MapDescription, NamesTheLineThatIsNoYaml) {
  EXPECT_THAT(errorOf(with("[-1, -2, 0]", "[-1, -2, 0")), HasSubstr("is no YAML"));
  EXPECT_THAT(errorOf("image: map.pgm\nresolution: 0.05\n\torigin: x\n"), HasSubstr("line 3 is no YAML"));
  for (const char* const other : {"", "map.pgm", "- 1\n- 2\n", "# nothing\n"})
    EXPECT_THAT(errorOf(other), HasSubstr("holds no keys with values")) << other;
}

TEST(MapDescription, OfAnyNestingIsRefusedOrRead) {
  for (const char* const opening : {"[", "{a: ", "- ", "? ", "&a [*a, "}) {
    std::string nested = "image: ";
    for (int i = 0; i < 20'000; ++i) nested += opening;
    EXPECT_NE(errorOf(nested), "") << opening;
  }
  EXPECT_THAT(errorOf("image: &a [*a]\nresolution: *a\norigin: *a\n"), HasSubstr("image: a list or map"));
}

TEST(MapDescription, WrittenIsReadBackWithItsDigits) {
  MapImage image{.width = 1, .height = 1, .cells = {MapImage::kFree}};
  image.resolution = 0.05;
  image.origin_x = -247 * 0.05;  // -12.350000000000001
  image.origin_y = -0.0;
  EXPECT_EQ(encodeYaml("map.pgm", image),
            "image: map.pgm\nmode: trinary\nresolution: 0.05\norigin: [-12.35, 0, 0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
  std::mt19937 random(1);
  std::uniform_real_distribution<double> metres(-1e4, 1e4);
  for (int i = 0; i < 1000; ++i) {
    image.origin_x = metres(random);
    image.origin_y = 1e-8 * metres(random);
    image.resolution = 0.1 / (i + 1);
    const MapDescription read = parseMapDescription(encodeYaml("map.pgm", image));
    EXPECT_DOUBLE_EQ(read.T_map_picture.x, image.origin_x);
    EXPECT_DOUBLE_EQ(read.T_map_picture.y, image.origin_y);
    EXPECT_DOUBLE_EQ(read.resolution, image.resolution);
  }
}

TEST(CellsOfGreys, AreTheThreeValuesOfMapServersTrinaryMode) {
  MapDescription description;
  const auto cells = cellsOfGreys(description);
  EXPECT_EQ(cells[0], MapImage::kOccupied);
  EXPECT_EQ(cells[89], MapImage::kOccupied);  // p = 0.651
  EXPECT_EQ(cells[90], MapImage::kUnknown);   // p = 0.647
  EXPECT_EQ(cells[205], MapImage::kUnknown);  // p = 0.1961
  EXPECT_EQ(cells[206], MapImage::kFree);     // p = 0.192
  EXPECT_EQ(cells[255], MapImage::kFree);
  description.free_threshold = 0.25;
  EXPECT_EQ(cellsOfGreys(description)[205], MapImage::kUnknown) << "unknown whatever the thresholds";
  EXPECT_EQ(cellsOfGreys(description)[204], MapImage::kFree);
  description.negate = true;
  EXPECT_EQ(cellsOfGreys(description)[0], MapImage::kFree);
  EXPECT_EQ(cellsOfGreys(description)[205], MapImage::kOccupied);
  EXPECT_EQ(cellsOfGreys(description)[100], MapImage::kUnknown);
}

TEST(CellsOfGreys, OfShadesArePartedByTheirSharesOfTheRangeBetweenTheThresholds) {
  MapDescription description;
  description.mode = Mode::kScale;
  description.free_threshold = 0.2;
  description.occupied_threshold = 0.8;
  const auto cells = cellsOfGreys(description);
  EXPECT_EQ(cells[255], MapImage::kFree);
  EXPECT_EQ(cells[180], MapImage::kFree);  // p = 0.294, 16 % of the range
  EXPECT_EQ(cells[205], MapImage::kFree) << "a shade like the others";
  EXPECT_EQ(cells[128], MapImage::kUnknown);  // 50 %
  EXPECT_EQ(cells[80], MapImage::kOccupied);  // p = 0.686, 81 %
  EXPECT_EQ(cells[0], MapImage::kOccupied);
  description.free_threshold = description.occupied_threshold = 102 / 255.0;
  EXPECT_EQ(cellsOfGreys(description)[153], MapImage::kUnknown) << "a range without width";
}

TEST(CellsOfGreys, OfRawPicturesArePercent) {
  MapDescription description;
  description.mode = Mode::kRaw;
  description.negate = true;
  const auto cells = cellsOfGreys(description);
  EXPECT_EQ(cells[0], MapImage::kFree);
  EXPECT_EQ(cells[19], MapImage::kFree);
  EXPECT_EQ(cells[50], MapImage::kUnknown);
  EXPECT_EQ(cells[66], MapImage::kOccupied);
  EXPECT_EQ(cells[100], MapImage::kOccupied);
  EXPECT_EQ(cells[101], MapImage::kUnknown);
  EXPECT_EQ(cells[255], MapImage::kUnknown);
}

}  // namespace
}  // namespace slam::map_description_test
