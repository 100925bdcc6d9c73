// SPDX-License-Identifier: BSD-3-Clause
#include "store/log_policy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace slam::log_policy_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr LogLimits kLimits{.quota = 800, .floor = 1000, .file_length = 600s};
constexpr std::uint64_t kPlenty = 1'000'000;

std::vector<LogFile> filesOf(const std::vector<std::uint64_t>& bytes, const std::vector<std::int64_t>& marked = {}) {
  std::vector<LogFile> files;
  for (const std::uint64_t size : bytes) {
    const auto number = static_cast<std::int64_t>(files.size());
    const bool is_marked = std::find(marked.begin(), marked.end(), number) != marked.end();
    files.push_back({.path = "run/log.lcm", .number = number, .bytes = size, .marked = is_marked});
  }
  return files;
}

TEST(LogPolicy, NamesARunByDateAndBoot) {
  EXPECT_EQ(runName(1'764'052'675'999'999, "0123"), "2025-11-25T06-37-55Z_0123");
  EXPECT_EQ(runName(0, ""), "1970-01-01T00-00-00Z_unknown");
}

TEST(LogPolicy, NumbersFilesOnAcrossRuns) {
  EXPECT_EQ(nextNumber({}), 0);
  std::vector<LogFile> files = filesOf({1, 1, 1});
  std::reverse(files.begin(), files.end());
  EXPECT_EQ(nextNumber(files), 3);
}

TEST(LogPolicy, EndsAFileByTimeOrBySize) {
  EXPECT_FALSE(isFull(599s, 99, kLimits));
  EXPECT_TRUE(isFull(600s, 0, kLimits));
  EXPECT_TRUE(isFull(0s, 100, kLimits)) << "an eighth of the quota";
}

TEST(LogPolicy, StopsAtTheFloorAndGoesOnALittleAboveIt) {
  EXPECT_TRUE(hasRoom(1000, 1000, true));
  EXPECT_FALSE(hasRoom(999, 1000, true));
  EXPECT_FALSE(hasRoom(1099, 1000, false));
  EXPECT_TRUE(hasRoom(1100, 1000, false));
  EXPECT_TRUE(hasRoom(0, 0, false)) << "no floor is wanted";
}

TEST(LogPolicy, RemovesTheOldestFirst) {
  EXPECT_THAT(filesToRemove(filesOf({100, 100, 100, 100, 100, 100}), kPlenty, kLimits), IsEmpty());
  EXPECT_THAT(filesToRemove(filesOf({100, 100, 100, 100, 100, 101}), kPlenty, kLimits), ElementsAre(0));
  EXPECT_THAT(filesToRemove(filesOf({100, 100, 100, 100, 100, 250}), kPlenty, kLimits), ElementsAre(0, 1));
}

TEST(LogPolicy, RemovesMarkedFilesLast) {
  EXPECT_THAT(filesToRemove(filesOf({300, 300, 300}, {0}), kPlenty, kLimits), ElementsAre(1));
  EXPECT_THAT(filesToRemove(filesOf({300, 300, 300}, {0, 1, 2}), kPlenty, kLimits), ElementsAre(0));
  EXPECT_THAT(filesToRemove(filesOf({700, 300, 300}, {0}), kPlenty, kLimits), ElementsAre(1, 2, 0));
}

TEST(LogPolicy, MakesRoomAboveTheFloorWhereThatIsEnough) {
  EXPECT_THAT(filesToRemove(filesOf({100, 100, 100}), 1050, kLimits), IsEmpty());
  EXPECT_THAT(filesToRemove(filesOf({100, 100, 100}), 1049, kLimits), ElementsAre(0));
  EXPECT_THAT(filesToRemove(filesOf({100, 100, 100}, {0}), 900, kLimits), ElementsAre(1, 2));
  EXPECT_THAT(filesToRemove(filesOf({100, 100, 100}, {0}), 899, kLimits), IsEmpty())
      << "it is not the logs that fill the disk: nothing is gained";
  EXPECT_THAT(filesToRemove({}, 0, kLimits), IsEmpty());
}

TEST(LogPolicy, KeepsTheQuotaWhateverComes) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<std::uint64_t> bytes(random() % 30);
    for (std::uint64_t& size : bytes) size = random() % 400;
    std::vector<std::int64_t> marked;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (random() % 4 == 0) marked.push_back(static_cast<std::int64_t>(i));
    }
    const std::vector<LogFile> files = filesOf(bytes, marked);
    const auto gone = filesToRemove(files, random() % 3000, kLimits);
    std::uint64_t rest = 0;
    bool kept_unmarked = false, removed_marked = false;
    for (std::size_t i = 0; i < files.size(); ++i) {
      const bool removed = std::find(gone.begin(), gone.end(), i) != gone.end();
      if (!removed) rest += files[i].bytes;
      kept_unmarked |= !removed && !files[i].marked;
      removed_marked |= removed && files[i].marked;
    }
    EXPECT_LE(rest, kLimits.quota - 2 * kLimits.fileBytes());
    EXPECT_FALSE(kept_unmarked && removed_marked);
  }
}

}  // namespace
}  // namespace slam::log_policy_test
