// SPDX-License-Identifier: BSD-3-Clause
#include "store/disk_problem.hpp"

#include <cerrno>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdexcept>
#include <system_error>

#include "store/durable_file.hpp"
#include "tools/files.hpp"

namespace slam::disk_problem_test {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;

TEST(DiskProblem, NameTheRoomThatIsLeft) {
  const test::Folder folder;
  const Problem problem = diskProblem(DiskError("f: cannot write: No space", ENOSPC), folder / "maps");
  EXPECT_THAT(problem.cause(), MatchesRegex("no space on .*maps \\([0-9]+ MB free\\)"));
  EXPECT_THAT(problem.fix(), HasSubstr("make room"));
}

TEST(DiskProblem, NamesWhatIsWrongWithADisk) {
  const auto causeOf = [](int error) { return diskProblem(DiskError("f: cannot write: why", error), "/maps").cause(); };
  EXPECT_EQ(causeOf(EROFS), "/maps is read-only");
  EXPECT_THAT(causeOf(EIO), HasSubstr("reports errors: f: cannot write: why"));
  EXPECT_THAT(causeOf(EACCES), HasSubstr("f: cannot write: why"));
  EXPECT_THAT(causeOf(ENOENT), HasSubstr("has its disk gone?"));
  EXPECT_THAT(causeOf(EDQUOT), HasSubstr("quota"));
  EXPECT_EQ(causeOf(EFBIG), "f: cannot write: why");
  for (const int in_the_way : {EISDIR, EEXIST, ENOTEMPTY, ELOOP}) {
    EXPECT_EQ(causeOf(in_the_way), "f: cannot write: why");
    EXPECT_EQ(diskProblem(DiskError("f", in_the_way), "/maps").fix(),
              "something else lies in its place: move it out of /maps");
  }
}

TEST(DiskProblem, CoverErrorsOfTheLibraryAndAlwaysHaveAFix) {
  const std::system_error full(ENOSPC, std::generic_category(), "mkdir");
  EXPECT_THAT(diskProblem(full, "/").cause(), HasSubstr("no space"));
  EXPECT_EQ(diskProblem(std::runtime_error("odd"), "/").cause(), "odd");
  for (int error = 0; error < 134; ++error) EXPECT_NE(diskProblem(DiskError("x", error), "/").fix(), "");
}

}  // namespace
}  // namespace slam::disk_problem_test
