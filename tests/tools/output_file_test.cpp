// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/output_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/file_size_limit.hpp"
#include "tools/files.hpp"

namespace slam::output_file_test {
namespace {

TEST(OutputFile, HoldsWhatWasWritten) {
  const test::Folder folder;
  OutputFile file(folder / "a.csv");
  file.write("t,x\n");
  file.write("1,2\n");
  file.close();
  EXPECT_EQ(test::contentOf(folder / "a.csv"), "t,x\n1,2\n");
}

TEST(OutputFile, ReportsInOneLineWhatItCannotWrite) {
  const test::Folder folder;
  EXPECT_EQ(test::refusalOf([] { OutputFile("/dev/null/a.csv"); }),
            "/dev/null/a.csv: cannot write: its folder cannot be made: Not a directory");
  OutputFile file(folder / "a.csv");
  const test::FileSizeLimit full(0);
  file.write("t,x\n");
  EXPECT_THAT(test::refusalOf([&] { file.close(); }), testing::HasSubstr("a.csv: cannot write all of it"));
}

TEST(OutputFile, IsPreparedBeforeTheWorkOrRefused) {
  const test::Folder folder;
  namespace fs = std::filesystem;
  prepareOutput("");
  prepareMapFiles("");
  prepareOutput(folder / "new/and/deep/a.lcm");
  EXPECT_TRUE(fs::is_directory(folder / "new/and/deep"));
  EXPECT_FALSE(fs::exists(folder / "new/and/deep/a.lcm")) << "nothing is written yet";
  prepareOutput("beside.lcm");
  prepareOutput("/dev/null");
  folder.write("old", "is kept");
  prepareOutput(folder / "old");
  EXPECT_EQ(test::contentOf(folder / "old"), "is kept");
  prepareMapFiles(folder / "maps/kitchen");
  EXPECT_TRUE(fs::is_directory(folder / "maps"));
  fs::create_directories(folder / "maps/hall.pgm");
  using testing::HasSubstr;
  EXPECT_THAT(test::refusalOf([&] { prepareMapFiles(folder / "maps/hall"); }),
              HasSubstr("hall.pgm: cannot write: it is a folder, not a file"));
  EXPECT_THAT(test::refusalOf([&] { prepareOutput(folder / "maps/"); }), HasSubstr("it is a folder"));
  EXPECT_THAT(test::refusalOf([&] { prepareOutput(folder / "old/a.lcm"); }),
              HasSubstr("old/a.lcm: cannot write: its folder cannot be made: Not a directory"));
  EXPECT_THAT(test::refusalOf([&] { prepareOutput("/proc/a.lcm"); }), HasSubstr("/proc/a.lcm: cannot write: "));
  EXPECT_THAT(test::refusalOf([&] { prepareMapFiles("/proc/a"); }), HasSubstr("cannot write: "));
}

}  // namespace
}  // namespace slam::output_file_test
