// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/logs/log_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tools/files.hpp"

namespace slam::log_folder_test {
namespace {

namespace fs = std::filesystem;

class Logs : public testing::Test {
 protected:
  Logs() {
    fs::create_directories(files_ / "logs/run");
    files_.write("logs/run/0001.lcm", "records");
    files_.write("logs/run/0002.lcm.gz", "more");
    files_.write("secret", "not yours");
    fs::create_symlink("../secret", files_ / "logs/link");
    fs::create_symlink("../../secret", files_ / "logs/run/link");
    fs::create_directory_symlink("..", files_ / "logs/up");
  }
  std::vector<std::string> names(const std::vector<std::string>& parts) {
    std::vector<std::string> names;
    for (const LogFolder::Entry& entry : folder_.list(parts).value_or(std::vector<LogFolder::Entry>{}))
      names.push_back(entry.name);
    return names;
  }

  test::Folder files_;
  LogFolder folder_{files_ / "logs"};
};

TEST_F(Logs, AreListedTheNewestFirstWithoutLinks) {
  EXPECT_THAT(names({}), testing::ElementsAre("run"));
  EXPECT_THAT(names({"run"}), testing::ElementsAre("0002.lcm.gz", "0001.lcm"));
  EXPECT_EQ(folder_.list({"run"})->back().size, 7U);
  EXPECT_FALSE(folder_.list({"run", "0001.lcm"})) << "a file is no folder";
}

TEST_F(Logs, AreReadInParts) {
  const auto file = folder_.open({"run", "0001.lcm"});
  ASSERT_TRUE(file);
  EXPECT_EQ(file->size(), 7U);
  char bytes[16] = {};
  EXPECT_EQ(file->read(3, bytes, sizeof bytes), 4U);
  EXPECT_STREQ(bytes, "ords");
  EXPECT_EQ(file->read(7, bytes, sizeof bytes), 0U);
}

TEST_F(Logs, LeadNowhereElse) {
  EXPECT_FALSE(folder_.open({"link"}));
  EXPECT_FALSE(folder_.open({"run", "link"}));
  EXPECT_FALSE(folder_.open({"up", "secret"}));
  EXPECT_FALSE(folder_.open({"..", "secret"}));
  EXPECT_FALSE(folder_.open({"run", "../../secret"}));
  EXPECT_FALSE(folder_.list({".."}));
  EXPECT_FALSE(folder_.list({"up"}));
  EXPECT_FALSE(folder_.open({"/etc/passwd"}));
  EXPECT_FALSE(folder_.open({"run"})) << "a folder is no file";
}

TEST_F(Logs, DoNotWaitForAPipe) {
  ASSERT_EQ(mkfifo((files_ / "logs/run/pipe").c_str(), 0600), 0);
  EXPECT_FALSE(folder_.open({"run", "pipe"}));
  EXPECT_THAT(names({"run"}), testing::Not(testing::Contains("pipe")));
}

TEST(LogFolder, MayBeMissing) {
  EXPECT_FALSE(LogFolder("").list({}));
  EXPECT_FALSE(LogFolder("/nonexistent/logs").list({}));
  EXPECT_FALSE(LogFolder("/nonexistent/logs").open({"a"}));
}

}  // namespace
}  // namespace slam::log_folder_test
