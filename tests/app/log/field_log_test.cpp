// SPDX-License-Identifier: BSD-3-Clause
#include "app/log/field_log.hpp"

#include <csignal>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <sys/stat.h>
#include <vector>

#include "app/log/recorder.hpp"
#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "config/loader.hpp"
#include "config/printer.hpp"
#include "store/log_folder.hpp"
#include "support/file_size_limit.hpp"
#include "support/slow_disk.hpp"
#include "support/wait_until.hpp"
#include "tools/files.hpp"

namespace slam::field_log_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::waitUntil;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A field log behind its recorder, as the bus thread has them.
struct Logging {
  explicit Logging(const Config& config, std::size_t capacity = Recorder::kCapacity)
      : log(new FieldLog(config, clock, [] {})), recorder("log", std::unique_ptr<FieldLog>(log), capacity) {}

  void add(std::uint8_t value, std::size_t size = 1000) {
    if (log->takes(channel::kScan))
      recorder.add(clock.utime(monotonicNow()), channel::kScan, std::vector<std::uint8_t>(size, value));
  }
  /// Adds a message and waits until it is written.
  [[nodiscard]] bool write(std::uint8_t value, std::size_t size = 1000) {
    const std::uint64_t before = recorder.counters().written;
    add(value, size);
    return waitUntil([&] { return recorder.counters().written > before; });
  }
  MapAnswer ask(LogCommand::Kind kind, const std::string& what = "") {
    EXPECT_TRUE(log->command({kind, 7, what}));
    MapAnswer answer;
    EXPECT_TRUE(waitUntil([&] { return log->answers().popOne([&](const MapAnswer& given) { answer = given; }); }));
    return answer;
  }
  std::string problem() const { return recorder.report(monotonicNow()).problem.words(); }
  [[nodiscard]] bool finish() { return recorder.finish(monotonicNow() + 20s); }

  WallClock clock;
  FieldLog* log;
  Recorder recorder;
};

class FieldLogs : public testing::Test {
 protected:
  FieldLogs() {
    config.log.directory = folder / "logs";
    config.log.floor = 0.0;
  }
  std::vector<LogFile> files() const { return logFilesIn(config.log.directory); }
  /// First byte of each scan of a file that must be whole and begin with the configuration.
  static std::vector<int> valuesIn(const fs::path& file) {
    std::vector<int> values;
    EventLogReader reader(file);
    LogEvent event;
    EXPECT_TRUE(reader.next(event));
    EXPECT_EQ(event.channel, channel::kConfig);
    while (reader.next(event)) values.push_back(event.data.at(0));
    EXPECT_EQ(reader.skippedBytes(), 0U);
    EXPECT_FALSE(reader.truncated());
    return values;
  }
  std::vector<int> values() const {
    std::vector<int> all;
    for (const LogFile& file : files()) {
      for (const int value : valuesIn(file.path)) all.push_back(value);
    }
    return all;
  }

  const test::Folder folder;
  Config config;
};

TEST_F(FieldLogs, BeginsEachFileWithTheConfigurationThatReadsBack) {
  config.log.file_length = 1.0;
  config.front_end.ekf.gyro_sigma = 0.0123;
  Logging logging(config);
  logging.log->setMap(42);
  int value = 0;
  ASSERT_TRUE(waitUntil([&] { return logging.write(static_cast<std::uint8_t>(value++)) && files().size() >= 3; }));
  ASSERT_TRUE(logging.finish());
  EXPECT_GE(files().size(), 3U);
  for (const LogFile& file : files()) {
    EventLogReader reader(file.path);
    LogEvent event;
    ASSERT_TRUE(reader.next(event));
    const auto message = decodeChecked<config_t>(event.data);
    ASSERT_TRUE(message) << file.path;
    EXPECT_EQ(message->map_id, 42);
    EXPECT_EQ(message->boot_id.size(), 32U);
    EXPECT_THAT(message->versions, HasSubstr("slamd "));
    EXPECT_EQ(printConfig(parseConfig(message->configuration, "log")), printConfig(config));
    EXPECT_THAT(file.run(), HasSubstr("Z_" + message->boot_id));
  }
  std::vector<int> expected(static_cast<std::size_t>(value));
  for (int i = 0; i < value; ++i) expected[static_cast<std::size_t>(i)] = i;
  EXPECT_EQ(values(), expected);
}

TEST_F(FieldLogs, KeepsTheWebPagesTokenOutOfTheLog) {
  config.web.commands = true;
  config.web.token = "a-secret-of-the-robot";
  Logging logging(config);
  ASSERT_TRUE(logging.write(1));
  ASSERT_TRUE(logging.finish());
  ASSERT_EQ(files().size(), 1U);
  EventLogReader reader(files()[0].path);
  LogEvent event;
  ASSERT_TRUE(reader.next(event));
  const auto message = decodeChecked<config_t>(event.data);
  ASSERT_TRUE(message);
  EXPECT_THAT(message->configuration, testing::Not(HasSubstr(config.web.token)));
  EXPECT_NO_THROW(parseConfig(message->configuration, "log"));
}

TEST_F(FieldLogs, CompressesWhatIsClosed) {
  config.log.file_length = 1.0;
  Logging logging(config);
  const auto compressed = [&] {
    const auto all = files();
    return std::count_if(all.begin(), all.end(), [](const LogFile& f) { return f.path.extension() == ".gz"; });
  };
  ASSERT_TRUE(waitUntil([&] { return logging.write(1) && compressed() >= 2; }));
  ASSERT_TRUE(logging.finish());
  EXPECT_THAT(values(), testing::Each(1));
}

TEST_F(FieldLogs, LeavesTheLogOfTheRunBefore) {
  for (std::uint8_t run = 1; run <= 3; ++run) {
    Logging logging(config);  // within one second: the names would be the same
    ASSERT_TRUE(logging.write(run));
    ASSERT_TRUE(logging.finish());
  }
  EXPECT_THAT(values(), ElementsAre(1, 2, 3));
  EXPECT_EQ(std::distance(fs::directory_iterator(config.log.directory), {}), 3 + 1) << "three runs and the lock";
}

TEST_F(FieldLogs, IsOrderedWhereTheClockWasSetBack) {
  {
    Logging before(config);
    ASSERT_TRUE(before.write(1));
    ASSERT_TRUE(before.finish());
  }
  const fs::path later = folder / "logs/2199-01-01T00-00-00Z_later";
  fs::rename(files().at(0).path.parent_path(), later);
  fs::rename(later / "0000.lcm", later / "0041.lcm");
  Logging logging(config);
  ASSERT_TRUE(logging.write(2));
  ASSERT_TRUE(logging.finish());
  EXPECT_THAT(values(), ElementsAre(1, 2));
  EXPECT_EQ(files().back().number, 42);
}

TEST_F(FieldLogs, TakesRawSensorsOrAll) {
  Logging raw(config);
  for (const char* name : {channel::kScan, channel::kWheels, channel::kImu, channel::kDepth})
    EXPECT_TRUE(raw.log->takes(name)) << name;
  for (const char* name : {channel::kPose, channel::kMapTile, channel::kHealth, channel::kCommand})
    EXPECT_FALSE(raw.log->takes(name)) << name;
  config.log.content = LogContent::kAll;
  config.log.directory = folder / "other";
  Logging all(config);
  EXPECT_TRUE(all.log->takes(channel::kMapTile));
}

TEST_F(FieldLogs, BeginsAndEndsAsCommanded) {
  config.log.automatic = false;
  Logging logging(config);
  EXPECT_FALSE(logging.log->takes(channel::kScan));
  logging.add(1);
  const MapAnswer unmarked = logging.ask(LogCommand::kMark, "crash");
  EXPECT_FALSE(unmarked.accepted) << "there is nothing to mark";
  EXPECT_THAT(unmarked.answer.words, HasSubstr("the log is stopped; begin it with slamctl log start"));
  EXPECT_TRUE(logging.ask(LogCommand::kStart).accepted);
  ASSERT_TRUE(logging.write(2));
  EXPECT_TRUE(logging.ask(LogCommand::kStop).accepted);
  logging.add(3);
  EXPECT_TRUE(logging.ask(LogCommand::kStart).accepted);
  ASSERT_TRUE(logging.write(4));
  EXPECT_EQ(files().size(), 2U);
  ASSERT_TRUE(logging.finish());
  EXPECT_THAT(values(), ElementsAre(2, 4));
  EXPECT_EQ(logging.recorder.counters().dropped, 0U);
}

TEST_F(FieldLogs, MarksThePresentFileAndThoseOfTheTenMinutesBefore) {
  config.log.file_length = 1.0;
  Logging logging(config);
  const auto isCompressed = [&](std::size_t i) { return files()[i].path.extension() == ".gz"; };
  ASSERT_TRUE(waitUntil([&] { return logging.write(1) && files().size() >= 4 && isCompressed(0) && isCompressed(1); }));
  const auto now = std::filesystem::file_time_type::clock::now();
  std::filesystem::last_write_time(files()[0].path, now - 11min);
  std::filesystem::last_write_time(files()[1].path, now - 9min);
  const MapAnswer answer = logging.ask(LogCommand::kMark, "hit\nthe wall");
  EXPECT_TRUE(answer.accepted) << answer.answer.words;
  ASSERT_TRUE(logging.finish());
  const auto all = files();
  EXPECT_FALSE(all[0].marked);
  std::vector<std::string> words;
  for (const LogFile& file : all) {
    if (file.marked) words.push_back(markOf(file));
  }
  ASSERT_EQ(words.size(), 3U);
  for (const std::string& line : words) {
    EXPECT_THAT(line, HasSubstr("hit the wall\n"));
    EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  }
}

TEST_F(FieldLogs, GivesTheImagesOfEachFileItsNumber) {
  config.log.file_length = 1.0;
  config.log.quota = 80.0;
  {
    Logging without(config);
    ASSERT_TRUE(without.write(1));
    EXPECT_EQ(without.log->imagesPath(), "");
    ASSERT_TRUE(without.finish());
  }
  config.log.images = true;
  Logging logging(config);
  EXPECT_EQ(logging.log->imagesPath(), "");
  ASSERT_TRUE(logging.write(2));
  const std::string first = logging.log->imagesPath();
  EXPECT_THAT(first, testing::EndsWith("/0001.oni"));
  ASSERT_TRUE(waitUntil([&] { return logging.write(2) && logging.log->imagesPath() != first; }));
  ASSERT_TRUE(logging.finish());
  EXPECT_EQ(logging.log->imagesPath(), "");
}

TEST_F(FieldLogs, KeepsAQuotaThatIsSmallerThanOneFile) {
  config.log.quota = 1.0;  // 1 MB, of which a file takes an eighth
  Logging logging(config);
  std::uint64_t most = 0;
  for (int i = 0; i < 120; ++i) {
    ASSERT_TRUE(logging.write(static_cast<std::uint8_t>(i), 30'000));
    std::uint64_t sum = 0;
    for (const auto& entry : fs::recursive_directory_iterator(config.log.directory)) {
      std::error_code gone;
      const auto size = entry.is_regular_file(gone) ? entry.file_size(gone) : 0;
      sum += gone ? 0 : size;
    }
    most = std::max(most, sum);
  }
  ASSERT_TRUE(logging.finish());
  EXPECT_GT(files().size(), 2U);
  EXPECT_LT(most, 2'000'000U) << "it was 3.6 MB";
  EXPECT_EQ(values().back(), 119) << "the newest stay";
}

TEST_F(FieldLogs, StopsAtTheFloorAndReportsIt) {
  config.log.floor = 1e6;  // [MB] no disk here has as much free
  Logging logging(config);
  logging.add(1);
  ASSERT_TRUE(waitUntil([&] { return !logging.problem().empty(); }));
  EXPECT_THAT(logging.problem(), AllOf(HasSubstr("are free where log.floor keeps 1000000 MB"),
                                       HasSubstr("nothing is logged"), HasSubstr("make room")));
  const MapAnswer unmarked = logging.ask(LogCommand::kMark, "crash");
  EXPECT_FALSE(unmarked.accepted);
  EXPECT_THAT(unmarked.answer.words, AllOf(HasSubstr("log.floor keeps 1000000 MB"), HasSubstr("make room")));
  EXPECT_FALSE(logging.finish());
  EXPECT_THAT(files(), IsEmpty());
}

TEST_F(FieldLogs, BeginsWhenItsFolderCanBeMade) {
  folder.write("disk", "not mounted yet");
  config.log.directory = folder / "disk/logs";
  Logging logging(config);
  logging.add(1);
  ASSERT_TRUE(waitUntil([&] { return !logging.problem().empty(); }));
  EXPECT_THAT(logging.problem(), AllOf(HasSubstr("disk"), HasSubstr("nothing is logged"), HasSubstr("log.directory")));
  fs::remove(folder / "disk");
  ASSERT_TRUE(waitUntil([&] { return logging.problem().empty(); }));
  ASSERT_TRUE(logging.write(2));
  // It goes away and comes back.
  fs::rename(folder / "disk", folder / "away");
  ASSERT_TRUE(logging.write(3));
  ASSERT_TRUE(logging.finish());
  EXPECT_THAT(values(), ElementsAre(3));
  config.log.directory = folder / "away/logs";
  EXPECT_THAT(values(), ElementsAre(1, 2));
}

TEST_F(FieldLogs, LeavesNoEmptyFileOnAFullDisk) {
  const test::FileSizeLimit limit(1000);  // not even the configuration
  Logging logging(config);
  logging.add(1);
  ASSERT_TRUE(waitUntil([&] { return !logging.problem().empty(); }));
  EXPECT_THAT(logging.problem(), HasSubstr("nothing is logged"));
  EXPECT_THAT(files(), IsEmpty());
  EXPECT_FALSE(logging.finish());
  EXPECT_EQ(logging.recorder.counters().dropped, 1U);
}

TEST_F(FieldLogs, GoesOnBehindAFullDiskWithWholeFiles) {
  Logging logging(config);
  ASSERT_TRUE(logging.write(1));
  {
    const test::FileSizeLimit limit(1000);  // not even the configuration
    for (int i = 2; i < 6; ++i) logging.add(static_cast<std::uint8_t>(i));
    ASSERT_TRUE(waitUntil([&] { return !logging.problem().empty(); }));
    EXPECT_THAT(values(), ElementsAre(1));
  }
  ASSERT_TRUE(waitUntil([&] { return logging.problem().empty(); }));
  ASSERT_TRUE(logging.finish());
  EXPECT_THAT(values(), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(logging.recorder.counters().dropped, 0U);
}

TEST_F(FieldLogs, LeavesAFolderToTheSlamdThatHasIt) {
  Logging first(config), second(config);
  ASSERT_TRUE(waitUntil([&] { return first.problem() != second.problem(); }));
  Logging& loser = first.problem().empty() ? second : first;
  Logging& winner = first.problem().empty() ? first : second;
  EXPECT_THAT(loser.problem(), HasSubstr("another slamd"));
  ASSERT_TRUE(winner.write(1));
  ASSERT_TRUE(winner.finish());
  EXPECT_THAT(values(), ElementsAre(1));
}

TEST_F(FieldLogs, LetsNobodyWaitForADiskThatStalls) {
  Logging logging(config, 100'000);
  ASSERT_TRUE(logging.write(1));
  test::HangingDisk disk;
  ASSERT_TRUE(waitUntil([&] {
    logging.add(2);
    return logging.recorder.report(monotonicNow()).waiting > 0ms && logging.recorder.counters().dropped > 0;
  }));
  EXPECT_FALSE(logging.recorder.finish(monotonicNow() + 50ms));
  disk.release();
  ASSERT_TRUE(waitUntil(
      [&] { return logging.recorder.finish(monotonicNow() + 10ms) || logging.recorder.counters().written > 1; }));
  (void)logging.finish();
  EXPECT_EQ(values().size(), logging.recorder.counters().written);
}

}  // namespace
}  // namespace slam::field_log_test
