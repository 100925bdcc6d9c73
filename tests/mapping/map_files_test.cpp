// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/map_files.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include "core/plausibility.hpp"
#include "mapping/picture_files.hpp"
#include "support/absurd.hpp"

namespace slam::map_files_test {
namespace {

namespace fs = std::filesystem;
using test::png;
using testing::AllOf;
using testing::HasSubstr;

class MapFiles : public testing::Test {
 protected:
  MapFiles() {
    folder_ = fs::path(testing::TempDir()) / ("slamd_map_files_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~MapFiles() override { fs::remove_all(folder_); }

  fs::path file(const std::string& name) const { return folder_ / name; }
  std::string content(const std::string& name) const {
    std::ifstream stream(file(name), std::ios::binary);
    EXPECT_TRUE(stream) << name;
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  void put(const std::string& name, const std::string& text) const {
    std::ofstream(file(name), std::ios::binary) << text;
  }
  /// @return what the error of reading `name` says; empty without an error
  std::string readError(const std::string& name) const {
    try {
      readMapFiles(file(name));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return {};
  }

  fs::path folder_;
};

MapImage randomImage(int width, int height) {
  std::mt19937 random(1);
  MapImage image{
      .width = width, .height = height, .resolution = 0.05, .origin_x = -12.35, .origin_y = 3.7, .cells = {}};
  constexpr std::uint8_t kValues[] = {MapImage::kOccupied, MapImage::kFree, MapImage::kUnknown};
  for (int i = 0; i < width * height; ++i) image.cells.push_back(kValues[random() % 3]);
  return image;
}

void expectSame(const MapImage& actual, const MapImage& expected) {
  EXPECT_EQ(actual.width, expected.width);
  EXPECT_EQ(actual.height, expected.height);
  EXPECT_NEAR(actual.resolution, expected.resolution, 1e-9);
  EXPECT_NEAR(actual.origin_x, expected.origin_x, 1e-6);
  EXPECT_NEAR(actual.origin_y, expected.origin_y, 1e-6);
  EXPECT_EQ(actual.cells, expected.cells);
}

constexpr char kYaml[] =
    "image: map.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1, -2, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
    "free_thresh: 0.196\n";

std::string pgm(const std::string& header, std::initializer_list<int> values) {
  std::string text = header;
  for (const int value : values) text.push_back(static_cast<char>(value));
  return text;
}

TEST_F(MapFiles, WhatWasWrittenIsReadBack) {
  for (const auto& [width, height] : {std::pair{1, 1}, {37, 21}, {1, 300}, {300, 1}}) {
    const MapImage image = randomImage(width, height);
    writeMapFiles(file("map"), image);
    expectSame(readMapFiles(file("map.yaml")), image);
  }
}

TEST_F(MapFiles, ThePgmHasItsFirstRowAtTheTop) {
  MapImage image{.width = 2, .height = 3, .cells = std::vector<std::uint8_t>(6, MapImage::kUnknown)};
  image.at(0, 2) = MapImage::kOccupied;  // upper left
  image.at(1, 0) = MapImage::kFree;      // lower right
  writeMapFiles(file("map"), image);
  const std::string bytes = content("map.pgm");
  std::istringstream header(bytes);
  std::string magic;
  int width = 0, height = 0, maximum = 0;
  header >> magic >> width >> height >> maximum;
  EXPECT_EQ(magic, "P5");
  EXPECT_EQ(width, 2);
  EXPECT_EQ(height, 3);
  EXPECT_EQ(maximum, 255);
  ASSERT_GT(bytes.size(), 6U);
  EXPECT_EQ(bytes.substr(bytes.size() - 6), pgm("", {0, 205, 205, 205, 205, 254}));
}

TEST_F(MapFiles, WritesThreeFilesAndLeavesNoOthers) {
  const std::vector<Eigen::Vector2d> path{{-12.0, 3.8}, {-11.0, 4.0}, {1e6, -1e6}};   // also beyond the image
  for (int i = 0; i < 2; ++i) writeMapFiles(file("map"), randomImage(20, 10), path);  // the second over the first
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename());
  EXPECT_THAT(names, testing::UnorderedElementsAre("map.yaml", "map.pgm", "map.png"));
  EXPECT_EQ(content("map.png").substr(0, 4), "\x89PNG");
}

TEST_F(MapFiles, ThePictureForPeopleHasThePathWhereItWasDriven) {
  MapImage image = randomImage(20, 10);
  ColourImage expected = colourMap(image);
  std::vector<Eigen::Vector2d> path;
  for (const auto& [column, row] : {std::pair{0, 0}, {19, 9}, {7, 2}, {7, 3}}) {
    path.emplace_back(image.origin_x + (column + 0.5) * image.resolution,
                      image.origin_y + (row + 0.5) * image.resolution);
    expected.set(column, 9 - row, kPathColour);  // rows of a picture count from its top
  }
  writeMapFiles(file("map"), image, path);
  EXPECT_TRUE(content("map.png") == encodePng(expected));
  path[2].y() += image.resolution;
  writeMapFiles(file("map"), image, path);
  EXPECT_FALSE(content("map.png") == encodePng(expected)) << "one row off is seen";
}

TEST_F(MapFiles, ADotInThePrefixIsNoExtension) {
  writeMapFiles(file("map.2024"), randomImage(3, 3));
  expectSame(readMapFiles(file("map.2024.yaml")), randomImage(3, 3));
}

TEST_F(MapFiles, ReadsTheFilesOfOthers) {
  put("map.yaml", kYaml);
  put("map.pgm", pgm("P5\n# CREATOR: map_saver 0.05 m/pix\n2 2\n255\n", {0, 10, 205, 250}));
  const MapImage image = readMapFiles(file("map.yaml"));
  EXPECT_EQ(image.cells, (std::vector<std::uint8_t>{0, 0, 205, 254}));  // in the three values
  EXPECT_EQ(image.origin_x, -1.0);
  EXPECT_EQ(image.origin_y, -2.0);
}

struct Variant {
  const char* name;
  const char *key, *value;  // of kYaml, and what stands there instead
  std::string picture;      // of two rows: occupied, free; unknown, free
};

std::vector<Variant> variants() {
  using K = test::PngKind;
  const std::vector<std::uint8_t> greys = {0, 254, 205, 254};
  const std::string binary = pgm("P5\n2 2\n255\n", {0, 254, 205, 254});
  return {{"binary PGM", "", "", binary},
          {"PGM as text", "", "", "P2\n2 2\n255\n0 254\n205 254\n"},
          {"PGM of 16 bit", "", "", pgm("P5\n2 2\n65535\n", {0, 0, 255, 0, 205, 205, 255, 0})},
          {"grey PNG", "", "", png(2, 2, greys, K::kGrey)},
          {"PNG of colours", "", "", png(2, 2, greys, K::kColour)},
          {"PNG with opacity", "mode: trinary", "mode: scale", png(2, 2, {0, 255, 254, 255}, K::kGreyKeyed)},
          {"origin in lines", "[-1, -2, 0]", "\n- -1.0\n- -2.0\n- 0.0", binary},
          {"yaw of a quarter", "[-1, -2, 0]", "[-0.9, -2, 1.5707963]", pgm("P5 2 2 255\n", {205, 0, 254, 254})},
          {"negated", "negate: 0", "negate: 1", pgm("P5 2 2 255\n", {255, 0, 128, 0})},
          {"negated by a word", "negate: 0", "negate: true", pgm("P5 2 2 255\n", {255, 0, 128, 0})},
          {"scale", "mode: trinary", "mode: scale", pgm("P5 2 2 255\n", {0, 254, 140, 254})},
          {"raw", "mode: trinary", "mode: raw", pgm("P5 2 2 255\n", {100, 0, 255, 0})},
          {"without mode and negation", "mode: trinary\n", "", binary}};
}

TEST_F(MapFiles, OfEachVariantOfMapServerAreRead) {
  for (const auto& [name, key, value, picture] : variants()) {
    std::string yaml = kYaml;
    put("map.yaml", yaml.replace(yaml.find(key), std::string(key).size(), value));
    put("map.pgm", picture);
    EXPECT_EQ(readError("map.yaml"), "") << name;
    const MapImage image = readMapFiles(file("map.yaml"));
    EXPECT_EQ(image.cells, (std::vector<std::uint8_t>{0, 254, 205, 254})) << name;
    EXPECT_NEAR(image.origin_x, -1.0, 1e-6) << name;
    EXPECT_NEAR(image.origin_y, -2.0, 1e-6) << name;
    EXPECT_EQ(image.resolution, 0.05) << name;
  }
}

TEST_F(MapFiles, FindTheirPictureFromTheYamlsFolderOrAtAnyPath) {
  fs::create_directories(file("pictures"));
  put("pictures/a map.png", png(1, 1, {0}, test::PngKind::kGrey));
  for (const std::string& path : {std::string("pictures/a map.png"), file("pictures/a map.png").string()}) {
    std::string yaml = kYaml;
    put("map.yaml", yaml.replace(yaml.find("map.pgm"), 7, path));
    EXPECT_EQ(readMapFiles(file("map.yaml")).cells, std::vector<std::uint8_t>{0}) << path;
  }
}

TEST_F(MapFiles, WithAYawAreHeldToTheSameLimits) {
  put("map.pgm", pgm("P5 1 1 255\n", {0}));
  const auto errorOf = [&](const std::string& origin) {
    std::string yaml = kYaml;
    put("map.yaml", yaml.replace(yaml.find("[-1, -2, 0]"), 11, origin));
    return readError("map.yaml");
  };
  EXPECT_THAT(errorOf("[0, 0, 90]"), AllOf(HasSubstr("theta = 90 rad"), HasSubstr("give its yaw in radians")));
  EXPECT_THAT(errorOf("[-9999.99, 0, 3.14159]"), HasSubstr("left edge x"));
  put("map.pgm", "P5 50000 1 255\n" + std::string(50'000, '\0'));
  EXPECT_THAT(errorOf("[0, 0, 0.7]"), AllOf(HasSubstr("map.yaml: turned by its yaw"), HasSubstr("set it to 0")));
}

TEST_F(MapFiles, ThatAreDamagedAreNamed) {
  put("map.yaml", kYaml);
  put("map.pgm", "P5\n2");
  EXPECT_THAT(readError("map.yaml"), HasSubstr("map.pgm: its header"));
  put("map.yaml", "image: map.pgm\norigin: [");
  EXPECT_THAT(readError("map.yaml"), HasSubstr("map.yaml: line 2 is no YAML"));
}

TEST_F(MapFiles, MissingFilesAreNamed) {
  EXPECT_THAT(readError("absent.yaml"), HasSubstr("absent.yaml"));
  put("map.yaml", kYaml);
  EXPECT_THAT(readError("map.yaml"), HasSubstr("map.pgm"));
}

TEST_F(MapFiles, WhatIsNoFileIsNotWaitedForAndOfALargeOneNoMoreIsReadThanItsHeaderGives) {
  ASSERT_EQ(mkfifo(file("pipe.yaml").c_str(), 0600), 0);
  EXPECT_THAT(readError("pipe.yaml"), HasSubstr("pipe.yaml: cannot read: it is no file"));
  put("map.yaml", kYaml);
  ASSERT_EQ(mkfifo(file("map.pgm").c_str(), 0600), 0);
  EXPECT_THAT(readError("map.yaml"), HasSubstr("map.pgm: cannot read: it is no file"));
  fs::remove(file("map.pgm"));
  fs::create_directory(file("map.pgm"));
  EXPECT_THAT(readError("map.yaml"), HasSubstr("map.pgm: cannot read: it is no file"));
  fs::remove(file("map.pgm"));
  put("map.pgm", pgm("P5\n2 1\n255\n", {0, 254}));
  fs::resize_file(file("map.pgm"), 40'000'000'000);  // without blocks on the disk
  EXPECT_EQ(readMapFiles(file("map.yaml")).cells, (std::vector<std::uint8_t>{0, 254}));
  put("map.pgm", "P5\n150000 150000\n255\n");
  fs::resize_file(file("map.pgm"), 40'000'000'000);
  EXPECT_THAT(readError("map.yaml"), HasSubstr("150000 x 150000 cells are not"));
  fs::resize_file(file("map.yaml"), 40'000'000'000);
  EXPECT_THAT(readError("map.yaml"), AllOf(HasSubstr("map.yaml"), HasSubstr("40000000000 bytes")));
}

TEST_F(MapFiles, APlanThatCannotBeIsRefusedWithTheReason) {
  put("map.pgm", pgm("P5\n1 1\n255\n", {0}));
  const auto with = [&](const std::string& good, const std::string& bad) {
    std::string yaml = kYaml;
    put("map.yaml", yaml.replace(yaml.find(good), good.size(), bad));
    return readError("map.yaml");
  };
  for (const double value : test::absurdNumbers(kPlausible.farthest)) {
    std::ostringstream number;
    number << value;
    for (const std::string& origin : {"[" + number.str() + ", -2, 0]", "[-1, " + number.str() + ", 0]"})
      EXPECT_THAT(with("[-1, -2, 0]", origin), HasSubstr(std::isfinite(value) ? "map's origin" : "origin")) << origin;
    EXPECT_THAT(with("0.05", number.str()), HasSubstr("resolution")) << value;
  }
  for (const char* resolution : {"1e-300", "1e-9", "0.0009", "1.01", "50"})
    EXPECT_THAT(with("0.05", resolution), HasSubstr("for a cell is not between 0.001 m and 1 m")) << resolution;
  put("map.yaml", kYaml);
  put("map.pgm", pgm("P5\n20000 20000\n255\n", {0}));
  EXPECT_THAT(readError("map.yaml"), HasSubstr("20000 x 20000 cells are not"));
}

TEST_F(MapFiles, AFileThatCannotBeWrittenIsNamed) {
  try {
    writeMapFiles(file("no_such_folder") / "map", randomImage(2, 2));
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no_such_folder"));
  }
}

}  // namespace
}  // namespace slam::map_files_test
