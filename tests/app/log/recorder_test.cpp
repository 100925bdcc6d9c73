// SPDX-License-Identifier: BSD-3-Clause
#include "app/log/recorder.hpp"

#include <csignal>
#include <fcntl.h>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include "app/log/record_file.hpp"
#include "bus/event_log.hpp"
#include "runtime/clock.hpp"
#include "support/file_size_limit.hpp"
#include "support/wait_until.hpp"
#include "tools/files.hpp"

namespace slam::recorder_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::waitUntil;
using testing::HasSubstr;

class Recording : public testing::Test {
 protected:
  /// Message number `value`. @return its size
  std::size_t add(Recorder& recorder, std::uint8_t value, std::size_t size = 1000) {
    recorder.add(1'000'000 + value, "SLAM_POSE", std::vector<std::uint8_t>(size, value));
    return size;
  }
  static std::string problemOf(const Recorder& recorder) { return recorder.report(monotonicNow()).problem.words(); }
  static bool waits(const Recorder& recorder) { return recorder.report(monotonicNow()).waiting > 0ms; }
  /// First byte of each message of a log, which must be whole.
  static std::vector<int> valuesIn(const fs::path& file) {
    std::vector<int> values;
    EventLogReader reader(file);
    for (LogEvent event; reader.next(event);) values.push_back(event.data.at(0));
    EXPECT_EQ(reader.skippedBytes(), 0U);
    EXPECT_FALSE(reader.truncated());
    return values;
  }
  /// Of a pipe whose writer may still be filling it.
  static bool isFull(const std::string& pipe) {
    pollfd writer{open(pipe.c_str(), O_WRONLY | O_NONBLOCK), POLLOUT, 0};
    const bool writable = poll(&writer, 1, 0) == 1;
    close(writer.fd);
    return !writable;
  }
  static Timestamp soon() { return monotonicNow() + 20s; }

  const test::Folder folder;
};

TEST_F(Recording, WritesWhatLcmReads) {
  Recorder recorder("record", std::make_unique<RecordFile>(folder / "record.lcm"));
  for (int i = 0; i < 100; ++i) add(recorder, static_cast<std::uint8_t>(i));
  ASSERT_TRUE(recorder.finish(soon()));
  const std::vector<int> values = valuesIn(folder / "record.lcm");
  ASSERT_EQ(values.size(), 100U);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(values[static_cast<std::size_t>(i)], i);
  EXPECT_EQ(recorder.counters().written, 100U);
  EXPECT_EQ(recorder.counters().dropped, 0U);
  EXPECT_EQ(problemOf(recorder), "");
  lcm::LogFile log(folder / "record.lcm", "r");
  const lcm::LogEvent* event = log.readNextEvent();
  ASSERT_NE(event, nullptr);
  EXPECT_EQ(event->channel, "SLAM_POSE");
  EXPECT_EQ(event->timestamp, 1'000'000);
  EXPECT_EQ(event->datalen, 1000);
}

TEST_F(Recording, LetsNobodyWaitForADiskThatStalls) {
  const std::string pipe = folder / "pipe";  // full, it keeps its writer waiting as a disk does
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  constexpr std::size_t kCapacity = 200'000;
  Recorder recorder("record", std::make_unique<RecordFile>(pipe), kCapacity);
  const auto fill = [&] {
    for (std::size_t bytes = 0; bytes < kCapacity / 2;) bytes += add(recorder, 1);
  };
  fill();  // more than the pipe takes
  ASSERT_TRUE(waitUntil([&] { return waits(recorder) && isFull(pipe); }));
  EXPECT_GE(recorder.report(monotonicNow() + 5s).waiting, 5s);
  const std::uint64_t written = recorder.counters().written;
  for (int i = 0; i < 3; ++i) fill();
  EXPECT_GT(recorder.counters().dropped, 0U) << "what cannot be kept is dropped, and nobody waits";
  EXPECT_EQ(recorder.counters().written, written);
  EXPECT_THAT(recorder.report(monotonicNow()).lost.words(),
              testing::AllOf(HasSubstr("messages are missing"), HasSubstr("the disk was away or too slow")));
  EXPECT_FALSE(recorder.finish(monotonicNow() + 50ms)) << "the end does not wait for ever either";

  // The disk is there again.
  std::ofstream copy(folder / "copy.lcm", std::ios::binary);
  std::vector<char> buffer(1 << 16);
  const auto drain = [&] {
    for (ssize_t got = 0; (got = read(reader, buffer.data(), buffer.size())) > 0;) copy.write(buffer.data(), got);
  };
  ASSERT_TRUE(waitUntil([&] {
    drain();
    return recorder.finish(monotonicNow() + 1ms);
  }));
  drain();
  copy.close();
  close(reader);
  EXPECT_EQ(valuesIn(folder / "copy.lcm").size(), recorder.counters().written);
}

TEST_F(Recording, BeginsWhenItsFolderCanBeMade) {
  folder.write("disk", "not mounted yet");
  Recorder recorder("record", std::make_unique<RecordFile>(folder / "disk/today/record.lcm"));
  add(recorder, 1);
  ASSERT_TRUE(waitUntil([&] { return !problemOf(recorder).empty(); }));
  EXPECT_THAT(problemOf(recorder),
              testing::AllOf(HasSubstr("disk"), HasSubstr("is not written"), HasSubstr("output.record")));
  fs::remove(folder / "disk");
  ASSERT_TRUE(waitUntil([&] { return problemOf(recorder).empty(); }));
  add(recorder, 2);
  ASSERT_TRUE(recorder.finish(soon()));
  EXPECT_THAT(valuesIn(folder / "disk/today/record.lcm"), testing::ElementsAre(1, 2));
}

TEST_F(Recording, GoesOnWhereItsFolderWasRemoved) {
  Recorder recorder("record", std::make_unique<RecordFile>(folder / "disk/record.lcm"));
  add(recorder, 1);
  ASSERT_TRUE(waitUntil([&] { return recorder.counters().written == 1; }));
  fs::remove_all(folder / "disk");
  add(recorder, 2);
  ASSERT_TRUE(recorder.finish(soon()));
  EXPECT_THAT(valuesIn(folder / "disk/record.lcm"), testing::ElementsAre(2));
}

TEST_F(Recording, GoesOnBehindAFullDiskWithWholeMessages) {
  Recorder recorder("record", std::make_unique<RecordFile>(folder / "record.lcm"));
  add(recorder, 1);
  ASSERT_TRUE(waitUntil([&] { return recorder.counters().written == 1; }));
  {
    const test::FileSizeLimit limit(5000);
    for (int i = 2; i < 12; ++i) add(recorder, static_cast<std::uint8_t>(i));
    ASSERT_TRUE(waitUntil([&] { return !problemOf(recorder).empty(); }));
    EXPECT_EQ(valuesIn(folder / "record.lcm").size(), recorder.counters().written);
  }
  ASSERT_TRUE(waitUntil([&] { return problemOf(recorder).empty(); }));
  ASSERT_TRUE(recorder.finish(soon()));
  EXPECT_EQ(valuesIn(folder / "record.lcm").size(), 11U);
  EXPECT_EQ(recorder.counters().dropped, 0U);
}

TEST_F(Recording, KeepsWhatARestartFinds) {
  for (std::uint8_t run = 1; run <= 2; ++run) {
    Recorder recorder("record", std::make_unique<RecordFile>(folder / "record.lcm"));
    for (int i = 0; i < 3; ++i) add(recorder, run);
    ASSERT_TRUE(recorder.finish(soon()));
  }
  EXPECT_THAT(valuesIn(folder / "record.lcm"), testing::ElementsAre(1, 1, 1, 2, 2, 2));
}

TEST_F(Recording, IsReadAcrossTheSeamWhereverThePowerWasCut) {
  const fs::path file = folder / "record.lcm";
  std::string first;
  for (std::uint8_t i = 1; i <= 3; ++i) appendRecord(first, i, i, "SLAM_POSE", std::vector<std::uint8_t>(40, i));
  const std::size_t record = first.size() / 3;
  for (std::size_t cut = 2 * record; cut <= 3 * record; cut += 7) {
    folder.write("record.lcm", first.substr(0, cut));
    {
      Recorder recorder("record", std::make_unique<RecordFile>(file));
      for (std::uint8_t i = 4; i <= 6; ++i) add(recorder, i);
      ASSERT_TRUE(recorder.finish(soon()));
    }
    std::vector<int> values;
    EventLogReader reader(file);
    for (LogEvent event; reader.next(event);) values.push_back(event.data.at(0));
    if (cut == 3 * record) {
      EXPECT_THAT(values, testing::ElementsAre(1, 2, 3, 4, 5, 6));
    } else {
      EXPECT_THAT(values, testing::ElementsAre(1, 2, 4, 5, 6)) << "cut at byte " << cut;
    }
  }
}

TEST_F(Recording, CountsWhatItCouldNotWriteAtTheEnd) {
  folder.write("disk", "not mounted");
  Recorder recorder("record", std::make_unique<RecordFile>(folder / "disk/record.lcm"));
  for (int i = 0; i < 7; ++i) add(recorder, 1);
  EXPECT_FALSE(recorder.finish(soon()));
  EXPECT_EQ(recorder.counters().dropped, 7U);
}

}  // namespace
}  // namespace slam::recorder_test
