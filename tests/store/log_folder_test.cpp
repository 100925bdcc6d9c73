// SPDX-License-Identifier: BSD-3-Clause
#include "store/log_folder.hpp"

#include <chrono>
#include <csignal>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include "store/durable_file.hpp"
#include "support/file_size_limit.hpp"
#include "tools/files.hpp"

namespace slam::log_folder_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

class LogFolder : public testing::Test {
 protected:
  fs::path put(const std::string& name, const std::string& content = "log") const {
    const fs::path file = folder / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << content;
    return file;
  }
  static std::vector<std::string> namesOf(const std::vector<LogFile>& files) {
    std::vector<std::string> names;
    for (const LogFile& file : files) names.push_back(file.run() + "/" + file.path.filename().string());
    return names;
  }
  static std::string unpacked(const fs::path& file) {
    gzFile in = gzopen(file.c_str(), "rb");
    std::string text;
    char block[4096];
    for (int got = 0; (got = gzread(in, block, sizeof block)) > 0;) text.append(block, static_cast<std::size_t>(got));
    gzclose(in);
    return text;
  }
  static std::string content(std::size_t bytes) {
    std::mt19937 random(7);
    std::string text(bytes, ' ');
    for (char& c : text) c = static_cast<char>(random() % 32);
    return text;
  }

  const test::Folder folder;
  const std::atomic<bool> go_on{false};
};

TEST_F(LogFolder, ListsFilesInTheOrderOfTheirNumbersWhateverTheirDates) {
  put("logs/1970_b/0002.lcm");
  put("logs/2026_a/0000.lcm.gz");
  put("logs/2026_a/0001.lcm");
  put("logs/1970_b/10000.lcm");
  put("logs/1970_b/9999.lcm.gz");
  put("logs/lock");
  put("logs/2026_a/notes.txt");
  put("logs/2026_a/0009.lcm.gz.part");
  EXPECT_THAT(namesOf(logFilesIn(folder / "logs")),
              ElementsAre("2026_a/0000.lcm.gz", "2026_a/0001.lcm", "1970_b/0002.lcm", "1970_b/9999.lcm.gz",
                          "1970_b/10000.lcm"));
  EXPECT_THAT(namesOf(logFilesIn(folder / "logs/2026_a")), ElementsAre("2026_a/0000.lcm.gz", "2026_a/0001.lcm"));
  EXPECT_THROW(logFilesIn(folder / "none"), std::runtime_error);
}

TEST_F(LogFolder, ReadsNothingTwiceWhereAPowerCutLeftBoth) {
  put("logs/run/0000.lcm", "plain");
  put("logs/run/0000.lcm.gz", "compressed");
  put("logs/run/0000.mark", "crash\n");
  const auto files = logFilesIn(folder / "logs");
  ASSERT_THAT(namesOf(files), ElementsAre("run/0000.lcm.gz"));
  EXPECT_EQ(files[0].bytes, 5U + 10U + 6U);
  EXPECT_TRUE(files[0].marked);
  EXPECT_EQ(markOf(files[0]), "crash\n");
  removeLog(files[0]);
  EXPECT_TRUE(fs::is_empty(folder / "logs/run"));
}

TEST_F(LogFolder, CountsImagesToo) {
  put("logs/run/0003.oni", "images");
  put("logs/run/0003-2.oni", "more");
  put("logs/run/0003.lcm");
  const auto files = logFilesIn(folder / "logs");
  EXPECT_THAT(namesOf(files), ElementsAre("run/0003-2.oni", "run/0003.lcm", "run/0003.oni"));
  EXPECT_FALSE(files[0].isLog());
  removeLog(files[0]);
  EXPECT_EQ(logFilesIn(folder / "logs").size(), 2U);
}

TEST_F(LogFolder, CompressesWithoutLosingAByte) {
  const std::string text = content(3'000'000);
  const fs::path file = put("run/0000.lcm", text);
  fs::last_write_time(file, fs::last_write_time(file) - std::chrono::minutes(11));
  const auto ended = fs::last_write_time(file);
  compressLog(file, go_on);
  EXPECT_EQ(fs::last_write_time(folder / "run/0000.lcm.gz"), ended);
  EXPECT_FALSE(fs::exists(folder / "run/0000.lcm"));
  EXPECT_LT(fs::file_size(folder / "run/0000.lcm.gz"), text.size());
  EXPECT_EQ(unpacked(folder / "run/0000.lcm.gz"), text);
}

TEST_F(LogFolder, KeepsThePlainFileWhereTheCompressedOneDoesNotFit) {
  const std::string text = content(3'000'000);
  const fs::path file = put("run/0000.lcm", text);
  {
    const test::FileSizeLimit limit(100'000);
    EXPECT_THROW(compressLog(file, go_on), std::runtime_error);
  }
  EXPECT_EQ(test::contentOf(file), text);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "run"), {}), 1) << "nothing half done is left";
  const std::atomic<bool> cancelled{true};
  compressLog(file, cancelled);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "run"), {}), 1);
  EXPECT_EQ(test::contentOf(file), text);
}

TEST_F(LogFolder, IsReadableWhereverCompressionIsKilled) {
  const std::string text = content(2'000'000);
  std::mt19937 random(3);
  for (int trial = 0; trial < 40; ++trial) {
    const fs::path file = put("run/0000.lcm", text);
    const pid_t child = fork();
    if (child == 0) {
      compressLog(file, go_on);
      _exit(0);
    }
    usleep(static_cast<useconds_t>(random() % 60000));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const auto files = logFilesIn(folder / "run");
    ASSERT_EQ(files.size(), 1U);
    ASSERT_EQ(unpacked(files[0].path), text) << files[0].path;
    tidyLogs(folder / "", folder / "run");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder / "run"), {}), 1);
    ASSERT_EQ(unpacked(logFilesIn(folder / "run").at(0).path), text);
    fs::remove_all(folder / "run");
  }
}

TEST_F(LogFolder, TidiesWhatAPowerCutLeft) {
  put("logs/old/0000.lcm", "plain");
  put("logs/old/0000.lcm.gz", "compressed");
  put("logs/old/0001.lcm", "plain");
  put("logs/old/0002.lcm.gz.part", "half");
  put("logs/old/0003.lcm", "");
  put("logs/lock", "");
  fs::create_directories(folder / "logs/empty");
  put("logs/present/0004.lcm", "");
  tidyLogs(folder / "logs", folder / "logs/present");
  EXPECT_THAT(namesOf(logFilesIn(folder / "logs")), ElementsAre("old/0000.lcm.gz", "old/0001.lcm", "present/0004.lcm"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "logs/old"), {}), 2);
  EXPECT_FALSE(fs::exists(folder / "logs/empty"));
  EXPECT_TRUE(fs::exists(folder / "logs/present"));
  EXPECT_TRUE(fs::exists(folder / "logs/lock"));
}

}  // namespace
}  // namespace slam::log_folder_test
