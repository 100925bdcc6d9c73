// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>
#include <vector>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "store/log_folder.hpp"
#include "tools/files.hpp"
#include "tools/slamctl/log.hpp"

namespace slam::log_tools_test {
namespace {

namespace fs = std::filesystem;
using test::refusalOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::int64_t kSecond = 1'000'000, kStart = 1'764'052'675 * kSecond;  // 2025-11-25 06:37:55

class LogTools : public testing::Test {
 protected:
  LogTools() { fs::create_directories(run); }
  /// A file of a run, with records at these seconds behind kStart.
  void put(int number, const std::vector<int>& seconds) const {
    EventLogWriter log(logPath(run, number));
    const std::uint8_t text[] = {static_cast<std::uint8_t>(number)};
    ASSERT_TRUE(log.write(kStart + seconds.front() * kSecond, channel::kConfig, text));
    for (const int second : seconds) {
      const std::uint8_t data[] = {static_cast<std::uint8_t>(second)};
      ASSERT_TRUE(log.write(kStart + second * kSecond, channel::kScan, data));
    }
    ASSERT_TRUE(log.flush());
  }
  std::vector<std::string> exported() const {
    std::vector<std::string> list;
    EventLogReader reader(out);
    for (LogEvent event; reader.next(event);) {
      list.push_back((event.channel == channel::kConfig ? "config " : "") +
                     std::to_string(static_cast<int>(event.data.at(0))));
    }
    return list;
  }

  const test::Folder folder;
  const fs::path logs = folder / "logs", run = logs / "2025-11-25T06-37-55Z_boot", out = folder / "out.lcm";
};

TEST_F(LogTools, ReadATimeAsAPersonWritesIt) {
  EXPECT_EQ(sinceTime("90s", kStart), kStart - 90 * kSecond);
  EXPECT_EQ(sinceTime("10min", kStart), kStart - 600 * kSecond);
  EXPECT_EQ(sinceTime("1.5h", kStart), kStart - 5400 * kSecond);
  EXPECT_EQ(sinceTime("2d", kStart), kStart - 172800 * kSecond);
  EXPECT_EQ(sinceTime("2025-11-25T06:37:55Z", 0), kStart);
  EXPECT_EQ(sinceTime("2025-11-25 06:37:55", 0), kStart);
  EXPECT_EQ(sinceTime("2025-11-25T06-37-55Z", 0), kStart);
  EXPECT_EQ(sinceTime("2025-11-25 06:37", 0), kStart - 55 * kSecond);
  EXPECT_EQ(sinceTime("1970-01-02", 0), 86400 * kSecond);
  for (const char* wrong : {"", "10", "min", "-5min", "nan h", "1e300h", "2025-13-45", "yesterday", "10 minutes"})
    EXPECT_THAT(refusalOf([&] { sinceTime(wrong, kStart); }), HasSubstr("is no time; write")) << wrong;
}

TEST_F(LogTools, ExportAllFilesIntoOneThatLiblcmReads) {
  put(0, {0, 1});
  put(1, {2, 3});
  const std::atomic<bool> go_on{false};
  compressLog(logPath(run, 0), go_on);
  const LogExport done = exportLogs(logs, std::nullopt, out);
  EXPECT_EQ(done.records, 4U);
  EXPECT_EQ(done.files, 2U);
  EXPECT_EQ(done.first, kStart);
  EXPECT_EQ(done.last, kStart + 3 * kSecond);
  EXPECT_THAT(exported(), ElementsAre("config 0", "0", "1", "config 1", "2", "3"));
  lcm::LogFile log(out, "r");
  int records = 0;
  while (log.readNextEvent() != nullptr) ++records;
  EXPECT_EQ(records, 6);
}

TEST_F(LogTools, ExportWhatIsNewerThanATime) {
  put(0, {0, 1});
  put(1, {2, 3, 4});
  put(2, {5, 6});
  EXPECT_EQ(exportLogs(logs, kStart + 4 * kSecond, out).records, 3U);
  EXPECT_THAT(exported(), ElementsAre("config 1", "4", "config 2", "5", "6"));
  EXPECT_THAT(refusalOf([&] { exportLogs(logs, kStart + 7 * kSecond, folder / "new.lcm"); }),
              HasSubstr("the newest is of 2025-11-25T06-38-01Z"));
  EXPECT_FALSE(fs::exists(folder / "new.lcm"));
}

TEST_F(LogTools, ExportWhatAPowerCutLeft) {
  put(0, {0, 1});
  put(1, {2, 3});
  put(2, {4});
  fs::resize_file(logPath(run, 1), fs::file_size(logPath(run, 1)) - 1);
  fs::resize_file(logPath(run, 2), 0);
  exportLogs(logs, std::nullopt, out);
  EXPECT_THAT(exported(), ElementsAre("config 0", "0", "1", "config 1", "2"));
  printLogs(logs);
}

TEST_F(LogTools, NeverOverwriteAnExport) {
  put(0, {0, 1});
  std::ofstream(out) << "precious";
  EXPECT_THAT(refusalOf([&] { exportLogs(logs, std::nullopt, out); }), HasSubstr("is there already"));
  EXPECT_EQ(test::contentOf(out), "precious");
  EXPECT_THAT(refusalOf([&] { exportLogs(folder / "none", std::nullopt, folder / "b.lcm"); }), HasSubstr("none"));
}

}  // namespace
}  // namespace slam::log_tools_test
