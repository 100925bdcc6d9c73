// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_manifest.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "store/durable_file.hpp"
#include "tools/files.hpp"

namespace slam::map_manifest_test {
namespace {

using test::refusalOf;
using testing::AllOf;
using testing::HasSubstr;

MapManifest someManifest() {
  return {.utime = 1'700'000'000'123'456,
          .order = 12,
          .keyframes = 17,
          .files = {{"graph.bin", {1234, 0xFFFFFFFF}}, {"state.toml", {0, 0}}}};
}

std::string sealed(const std::string& lines) { return lines + "crc32 " + std::to_string(crc32Of(lines)) + "\n"; }

TEST(MapManifest, ComesBackAsItWasWritten) {
  EXPECT_EQ(decodeManifest(encodeManifest(someManifest())), someManifest());
  EXPECT_EQ(decodeManifest(encodeManifest({})), MapManifest{});
}

TEST(MapManifest, IsWrittenAsSlamd01WroteIt) {
  const std::string lines = "slamd map\nversion 1\nutime 5\nkeyframes 2\nfile graph.bin 82 7\n";
  EXPECT_EQ(encodeManifest({.utime = 5, .keyframes = 2, .files = {{"graph.bin", {82, 7}}}}), sealed(lines));
}

TEST(MapManifest, EveryFlippedBitIsDamageAndNeverANewerVersion) {
  const std::string whole = encodeManifest(someManifest());
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string flipped = whole;
      flipped[at] = static_cast<char>(flipped[at] ^ (1 << bit));
      EXPECT_EQ(refusalOf([&] { decodeManifest(flipped); }), "is damaged (its CRC differs)") << at << " bit " << bit;
    }
  }
}

TEST(MapManifest, CutOffAnywhereIsDamage) {
  const std::string whole = encodeManifest(someManifest());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_EQ(refusalOf([&] { decodeManifest(whole.substr(0, size)); }), "is damaged (its CRC differs)") << size;
  }
  EXPECT_EQ(refusalOf([&] { decodeManifest(whole + "\n"); }), "is damaged (its CRC differs)");
}

TEST(MapManifest, OfANewerFormatIsNewerOnlyWhenItIsIntact) {
  const std::string lines = "slamd map\nversion 3\nfile new.bin 5 7 of another kind\nand more\n";
  EXPECT_THROW(decodeManifest(sealed(lines)), NewerMap);
  try {
    decodeManifest(sealed("version 3\norder 7\n"));
  } catch (const NewerMap& newer) {
    EXPECT_EQ(newer.order, 7) << "it keeps its place among the others";
  }
  EXPECT_THAT(refusalOf([&] { decodeManifest(sealed(lines)); }),
              AllOf(HasSubstr("format 3"), HasSubstr("newer slamd"), HasSubstr("update slamd")));
}

TEST(MapManifest, RefusesIntactLinesThatReportNothing) {
  for (const char* lines : {"", "slamd map\n", "version 0\n", "version -1\n", "version\n", "version 1\nutime x\n",
                            "version 1\norder\n", "version 1\nfile\n", "version 1\nfile graph.bin 5\n"}) {
    const std::string text = sealed(lines);
    EXPECT_NE(refusalOf([&] { decodeManifest(text); }), "") << lines;
  }
}

}  // namespace
}  // namespace slam::map_manifest_test
