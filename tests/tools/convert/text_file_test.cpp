// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/text_file.hpp"

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include "core/timestamp.hpp"
#include "tools/files.hpp"

namespace slam::text_file_test {
namespace {

using testing::ElementsAre;

std::vector<std::string> linesOf(const std::filesystem::path& path) {
  TextFile file(path);
  std::vector<std::string> lines;
  for (std::string line; file.next(line);) {
    lines.push_back(line);
    EXPECT_EQ(file.lineNumber(), static_cast<int>(lines.size()));
  }
  return lines;
}

TEST(TextFile, GivesEachLineOnce) {
  const test::Folder folder;
  EXPECT_THAT(linesOf(folder.write("a", "one\n\nthree\n")), ElementsAre("one", "", "three"));
  EXPECT_THAT(linesOf(folder.write("b", "one\nno line end")), ElementsAre("one", "no line end"));
  EXPECT_THAT(linesOf(folder.write("c", "")), ElementsAre());
  EXPECT_THROW(TextFile(folder / "missing"), std::runtime_error);
}

TEST(TextFile, GivesLongLinesWhole) {
  const test::Folder folder;
  const std::string one(300'000, 'x'), two((1 << 16) - 1, 'y');
  EXPECT_THAT(linesOf(folder.write("a", one + "\n" + two + "\nz\n")), ElementsAre(one, two, "z"));
}

TEST(TextFile, EndsALineOfDamageWhereItEnds) {
  const test::Folder folder;
  using namespace std::string_literals;
  EXPECT_THAT(linesOf(folder.write("a", "\v\0\ntwo\n\0\0x\nfour"s)), ElementsAre("\v\0"s, "two", "\0\0x"s, "four"));
}

TEST(TextFile, ReadsGzip) {
  const test::Folder folder;
  gzFile out = gzopen((folder / "a.gz").c_str(), "wb");
  gzputs(out, "one\ntwo\n");
  gzclose(out);
  EXPECT_THAT(linesOf(folder / "a.gz"), ElementsAre("one", "two"));
}

TEST(SplitWords, SplitsAtBlanksAndCommas) {
  EXPECT_THAT(splitWords("  a b\tc,d, e "), ElementsAre("a", "b", "c", "d", "e"));
  EXPECT_THAT(splitWords(""), ElementsAre());
  EXPECT_THAT(splitWords(" \t"), ElementsAre());
}

TEST(ToNumber, TakesWholeFiniteNumbersOnly) {
  EXPECT_EQ(toNumber("-1.5e2"), -150.0);
  EXPECT_EQ(toNumber("7"), 7.0);
  for (const char* bad : {"", "x", "1.5x", "1 ", "nan", "-nan", "inf", "-inf", "1e999", "--1", "."}) {
    EXPECT_FALSE(toNumber(bad)) << bad;
  }
  EXPECT_EQ(toNumbers(splitWords("FLASER 1 2.5"), 1), (std::vector{1.0, 2.5}));
  EXPECT_FALSE(toNumbers(splitWords("FLASER 1 2.5")));
}

TEST(ToMicroseconds, ReadsEveryDigit) {
  EXPECT_EQ(toMicroseconds("976052857.278917"), 976'052'857'278'917);
  EXPECT_EQ(toMicroseconds("1700000000.000001"), 1'700'000'000'000'001);
  EXPECT_EQ(toMicroseconds("2299999999.740993"), 2'299'999'999'740'993);
  EXPECT_EQ(toMicroseconds("12"), 12'000'000);
  EXPECT_EQ(toMicroseconds("0.5"), 500'000);
  EXPECT_EQ(toMicroseconds("12."), 12'000'000);
  const auto long_fraction = toMicroseconds("1.2345674999999999999999");
  ASSERT_TRUE(long_fraction);
  EXPECT_NEAR(static_cast<double>(*long_fraction), 1'234'567, 1);
}

TEST(ToMicroseconds, RefusesWhatIsNoTime) {
  for (const char* bad :
       {"", "x", "1.2.3", "1.2x", "nan", "inf", "99999999999999999999", "9223372036855.0", "2305843010", "."}) {
    EXPECT_FALSE(toMicroseconds(bad)) << bad;
  }
}

TEST(TextFile, EndsAtDamageOfCompressedDataAndReportsIt) {
  const std::string path = testing::TempDir() + "damaged_" + std::to_string(getpid()) + ".gz";
  gzFile out = gzopen(path.c_str(), "wb");
  for (int i = 0; i < 20000; ++i) gzprintf(out, "line %d %d\n", i, i * 7919 % 1000);
  gzclose(out);
  const auto size = std::filesystem::file_size(path);
  const auto readAll = [&] {
    TextFile file(path);
    int lines = 0;
    for (std::string line; lines < 30000 && file.next(line);) ++lines;
    return std::pair(lines, file.damaged());
  };
  EXPECT_EQ(readAll(), std::pair(20000, false));
  std::filesystem::resize_file(path, size / 2);  // cut off
  EXPECT_TRUE(readAll().second);
  EXPECT_LT(readAll().first, 20000);
  std::fstream(path, std::ios::in | std::ios::out | std::ios::binary)
      .seekp(static_cast<std::streamoff>(size / 4))
      .write("damage!", 7);
  EXPECT_TRUE(readAll().second);
  std::filesystem::remove(path);
  TextFile folder(testing::TempDir());
  std::string line;
  EXPECT_FALSE(folder.next(line));
}

}  // namespace
}  // namespace slam::text_file_test
