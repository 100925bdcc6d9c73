// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/output_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/file_size_limit.hpp"
#include "tools/files.hpp"

namespace slam {
namespace {

TEST(OutputFile, HoldsWhatWasWritten) {
  const test::Folder folder;
  OutputFile file(folder / "a.csv");
  file.write("t,x\n");
  file.write("1,2\n");
  file.close();
  EXPECT_EQ(test::contentOf(folder / "a.csv"), "t,x\n1,2\n");
}

TEST(OutputFile, SaysInOneLineWhatItCannotWrite) {
  const test::Folder folder;
  EXPECT_EQ(test::refusalOf([] { OutputFile("/nonexistent/a.csv"); }),
            "/nonexistent/a.csv: cannot write: No such file or directory");
  OutputFile file(folder / "a.csv");
  const test::FileSizeLimit full(0);
  file.write("t,x\n");
  EXPECT_THAT(test::refusalOf([&] { file.close(); }), testing::HasSubstr("a.csv: cannot write all of it"));
}

}  // namespace
}  // namespace slam
