// SPDX-License-Identifier: BSD-3-Clause
#include "bus/event_log.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <lcm/lcm-cpp.hpp>
#include <random>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <vector>
#include <zlib.h>

namespace slam::event_log_test {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr Bytes::value_type kSync[] = {0xED, 0xA1, 0xDA, 0x01};
constexpr std::size_t kHeader = 28;  // sync, event number, utime, lengths of channel and data

std::string temporary(const std::string& name) {
  return testing::TempDir() + "slamd_event_log_" + std::to_string(getpid()) + "_" + name;
}

/// A new file at each call, removed at the end.
class File {
 public:
  explicit File(const Bytes& content, const std::string& name = "file.lcm") : path(temporary(name)) {
    std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(content.data()), std::ssize(content));
  }
  ~File() { std::filesystem::remove(path); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  const std::string path;
};

struct Content {
  std::vector<LogEvent> events;
  std::uint64_t skipped = 0;
  bool truncated = false;
};

Content read(const std::string& path) {
  EventLogReader reader(path);
  Content content;
  for (LogEvent event; reader.next(event);) content.events.push_back(event);
  content.skipped = reader.skippedBytes();
  content.truncated = reader.truncated();
  return content;
}

bool same(const LogEvent& a, const LogEvent& b) {
  return a.utime == b.utime && a.channel == b.channel && a.data == b.data;
}
bool same(const std::vector<LogEvent>& a, const std::vector<LogEvent>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const LogEvent& x, const LogEvent& y) { return same(x, y); });
}

const std::vector<LogEvent>& someEvents() {
  static const std::vector<LogEvent> events = [] {
    std::vector<LogEvent> list;
    for (int i = 0; i < 8; ++i) {
      // No length damaged as below leads from one record to the begin of another, which no reader could tell.
      Bytes data(static_cast<std::size_t>(6 + 11 * i));
      for (std::size_t k = 0; k < data.size(); ++k)
        data[k] = static_cast<std::uint8_t>(31 * k + static_cast<unsigned>(i));
      list.push_back({1'700'000'000'000'000 + 1000 * i, i % 2 ? "SLAM_WHEELS" : "SLAM_SCAN", data});
    }
    return list;
  }();
  return events;
}

std::size_t sizeInLog(const LogEvent& event) { return kHeader + event.channel.size() + event.data.size(); }

Bytes logOf(const std::vector<LogEvent>& events) {
  const std::string path = temporary("written.lcm");
  {
    EventLogWriter writer(path);
    for (const LogEvent& event : events) EXPECT_TRUE(writer.write(event.utime, event.channel, event.data));
  }
  std::ifstream in(path, std::ios::binary);
  Bytes bytes{std::istreambuf_iterator<char>(in), {}};
  std::filesystem::remove(path);
  return bytes;
}

/// How many of the events given are in the list, in order.
std::size_t intact(const std::vector<LogEvent>& given, const std::vector<LogEvent>& list) {
  std::size_t count = 0, from = 0;
  for (const LogEvent& event : given) {
    for (std::size_t i = from; i < list.size(); ++i) {
      if (!same(list[i], event)) continue;
      ++count;
      from = i + 1;
      break;
    }
  }
  return count;
}

TEST(EventLog, GivesBackWhatWasWritten) {
  const Content content = read(File(logOf(someEvents())).path);
  EXPECT_TRUE(same(content.events, someEvents()));
  EXPECT_EQ(content.skipped, 0U);
  EXPECT_FALSE(content.truncated);
}

TEST(EventLog, IsReadByLiblcm) {
  const File file(logOf(someEvents()));
  lcm::LogFile log(file.path, "r");
  ASSERT_TRUE(log.good());
  for (std::size_t i = 0; i < someEvents().size(); ++i) {
    const lcm::LogEvent* event = log.readNextEvent();
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->eventnum, static_cast<std::int64_t>(i));
    EXPECT_EQ(event->timestamp, someEvents()[i].utime);
    EXPECT_EQ(event->channel, someEvents()[i].channel);
    EXPECT_EQ(event->datalen, static_cast<std::int32_t>(someEvents()[i].data.size()));
  }
  EXPECT_EQ(log.readNextEvent(), nullptr);
}

TEST(EventLog, MayHoldTheSyncWordInAMessage) {
  const std::vector<LogEvent> events = {{1, "A", Bytes(kSync, kSync + 4)}, {2, "B", {}}, {3, "C", {1}}};
  const Content content = read(File(logOf(events)).path);
  EXPECT_TRUE(same(content.events, events));
  EXPECT_EQ(content.skipped, 0U);
}

TEST(EventLogReader, GivesAllWholeRecordsOfALogCutAnywhere) {
  const Bytes bytes = logOf(someEvents());
  std::size_t whole = 0, end = sizeInLog(someEvents()[0]);
  for (std::size_t size = end; size < bytes.size(); ++size) {
    while (whole < someEvents().size() && end <= size) {
      ++whole;
      if (whole < someEvents().size()) end += sizeInLog(someEvents()[whole]);
    }
    const Content content = read(File(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))).path);
    ASSERT_EQ(content.events.size(), whole) << "cut to " << size;
    EXPECT_EQ(intact(someEvents(), content.events), whole) << "cut to " << size;
    const bool between_records = size == end - sizeInLog(someEvents()[whole]);
    EXPECT_EQ(content.truncated, !between_records) << "cut to " << size;
  }
}

/// As many records as a drive has, of the sizes of scans, wheels, IMU and map tiles.
std::vector<LogEvent> drive(std::mt19937& random) {
  std::vector<LogEvent> events;
  for (int i = 0; i < 400; ++i) {
    Bytes data(std::array{100U, 72U, 5800U, 60U}[random() % 4] + random() % 40);
    for (std::uint8_t& byte : data) byte = static_cast<std::uint8_t>(random() % 64);
    events.push_back({1'700'000'000'000'000 + 5000 * i, "SLAM_SCAN", std::move(data)});
  }
  return events;
}

TEST(EventLogReader, GivesAllWholeRecordsBeforeTenThousandRandomCuts) {
  std::mt19937 random(1);
  const std::vector<LogEvent> events = drive(random);
  const Bytes bytes = logOf(events);
  std::vector<std::size_t> ends;
  for (const LogEvent& event : events) ends.push_back((ends.empty() ? 0 : ends.back()) + sizeInLog(event));
  std::vector<std::size_t> cuts(10'000);
  for (std::size_t& cut : cuts) cut = random() % bytes.size();
  std::sort(cuts.rbegin(), cuts.rend());
  const File file(bytes);
  for (const std::size_t cut : cuts) {
    std::filesystem::resize_file(file.path, cut);
    const auto whole = static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), cut) - ends.begin());
    if (whole == 0) {
      try {
        EXPECT_EQ(read(file.path).events.size(), 0U);
      } catch (const EmptyLog&) {
      }
      continue;
    }
    const Content content = read(file.path);
    ASSERT_EQ(content.events.size(), whole) << "cut to " << cut;
    ASSERT_TRUE(same(content.events.back(), events[whole - 1])) << "cut to " << cut;
  }
}

TEST(EventLogReader, GivesWhatIsWholeInACutGzip) {
  std::mt19937 random(2);
  const std::vector<LogEvent> events = drive(random);
  const Bytes bytes = logOf(events);
  const std::string path = temporary("cut.lcm.gz");
  gzFile out = gzopen(path.c_str(), "wb1");
  ASSERT_EQ(gzwrite(out, bytes.data(), static_cast<unsigned>(bytes.size())), static_cast<int>(bytes.size()));
  gzclose(out);
  const auto size = std::filesystem::file_size(path);
  std::vector<std::size_t> cuts(300);
  for (std::size_t& cut : cuts) cut = size / 20 + random() % (size - size / 20);
  std::sort(cuts.rbegin(), cuts.rend());
  for (const std::size_t cut : cuts) {
    std::filesystem::resize_file(path, cut);
    const std::vector<LogEvent> found = read(path).events;
    ASSERT_TRUE(same(found, {events.begin(), events.begin() + std::ssize(found)})) << "cut to " << cut;
    // A block of deflate is decoded as a whole.
    EXPECT_GE(static_cast<double>(found.size() + 60),
              static_cast<double>(events.size() * cut) / static_cast<double>(size))
        << "cut to " << cut;
  }
  std::filesystem::remove(path);
}

TEST(EventLogSequence, ReadsFilesInTheOrderGiven) {
  const std::vector<LogEvent>& all = someEvents();
  const File first(logOf({all.begin(), all.begin() + 3}), "first.lcm"), empty({}, "empty.lcm"),
      last(logOf({all.begin() + 3, all.end()}), "last.lcm");
  EventLogSequence whole({first.path, last.path});
  std::vector<LogEvent> events;
  for (LogEvent event; whole.next(event);) events.push_back(event);
  EXPECT_TRUE(same(events, all));
  EXPECT_FALSE(whole.truncated());

  EventLogSequence with_empty({empty.path, first.path, empty.path, last.path, empty.path});
  events.clear();
  for (LogEvent event; with_empty.next(event);) events.push_back(event);
  EXPECT_TRUE(same(events, all));
  EXPECT_TRUE(with_empty.truncated());
  EXPECT_THROW(EventLogSequence({empty.path, empty.path}), EmptyLog);
  EXPECT_THROW(EventLogSequence({first.path + ".none"}), std::runtime_error);
}

TEST(EventLogSequence, CountsTheDamageOfAllFiles) {
  Bytes noise = logOf(someEvents());
  noise.insert(noise.begin(), 5, 0x55);
  noise.resize(noise.size() - 1);
  const File one(noise, "one.lcm"), two(noise, "two.lcm");
  EventLogSequence logs({one.path, two.path});
  const Content alone = read(one.path);
  int count = 0;
  for (LogEvent event; logs.next(event);) ++count;
  EXPECT_EQ(count, 2 * std::ssize(alone.events));
  EXPECT_EQ(logs.skippedBytes(), 2 * alone.skipped);
  EXPECT_TRUE(logs.truncated());
}

TEST(EventLogReader, LosesNoOtherRecordToOneDamagedByte) {
  const Bytes good = logOf(someEvents());
  std::size_t begin = 0, record = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    if (i == begin + sizeInLog(someEvents()[record])) begin += sizeInLog(someEvents()[record++]);
    for (const int flip : {0x01, 0x80, 0xFF}) {
      Bytes bytes = good;
      bytes[i] = static_cast<std::uint8_t>(bytes[i] ^ flip);
      const Content content = read(File(bytes).path);
      const std::string where = "byte " + std::to_string(i - begin) + " of record " + std::to_string(record) +
                                " flipped by " + std::to_string(flip);
      ASSERT_GE(intact(someEvents(), content.events), someEvents().size() - 1) << where;
      if (record + 1 < someEvents().size()) {
        ASSERT_FALSE(content.truncated) << where;
      }
    }
  }
}

TEST(EventLogReader, CountsTheBytesThatBelongToNoRecord) {
  const Bytes good = logOf(someEvents());
  const auto middle = static_cast<std::ptrdiff_t>(sizeInLog(someEvents()[0]) + sizeInLog(someEvents()[1]));
  Bytes bytes = good;
  bytes.insert(bytes.begin() + middle, 1000, 0x55);
  bytes.insert(bytes.begin(), 10, 0xED);
  const Content content = read(File(bytes).path);
  EXPECT_TRUE(same(content.events, someEvents()));
  EXPECT_EQ(content.skipped, 1010U);
}

TEST(EventLogReader, LosesNoRecordToAChannelThatReachesOverIt) {
  const LogEvent small{1, "A", {1, 2, 3}};
  const Bytes one = logOf({small});
  Bytes bytes(std::begin(kSync), std::end(kSync));
  bytes.resize(kHeader);
  bytes[23] = static_cast<std::uint8_t>(one.size());  // length of the channel: up to the beginning of a record
  for (int i = 0; i < 3; ++i) bytes.insert(bytes.end(), one.begin(), one.end());
  EXPECT_TRUE(same(read(File(bytes).path).events, {small, small, small}));
}

TEST(EventLogReader, PassesOverARecordWithoutAChannel) {
  Bytes bytes(std::begin(kSync), std::end(kSync));
  bytes.resize(kHeader);
  const Bytes good = logOf(someEvents());
  bytes.insert(bytes.end(), good.begin(), good.end());
  const Content content = read(File(bytes).path);
  EXPECT_TRUE(same(content.events, someEvents()));
  EXPECT_EQ(content.skipped, kHeader);
}

TEST(EventLogReader, ReadsGzip) {
  const std::string path = temporary("log.gz");
  const Bytes bytes = logOf(someEvents());
  gzFile out = gzopen(path.c_str(), "wb");
  ASSERT_EQ(gzwrite(out, bytes.data(), static_cast<unsigned>(bytes.size())), static_cast<int>(bytes.size()));
  gzclose(out);
  EXPECT_TRUE(same(read(path).events, someEvents()));

  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 12);  // copying stopped short
  const Content cut = read(path);
  EXPECT_GE(cut.events.size(), 1U);
  EXPECT_EQ(intact(someEvents(), cut.events), cut.events.size());
  std::filesystem::remove(path);
}

TEST(EventLogReader, RefusesWhatIsNoLog) {
  EXPECT_THROW(read(temporary("missing")), std::runtime_error);
  EXPECT_THROW(read(File({}).path), std::runtime_error);
  EXPECT_THROW(read(File(Bytes(100'000, 0x55)).path), std::runtime_error);
  EXPECT_THROW(read(testing::TempDir()), std::runtime_error);
}

TEST(EventLogWriter, ReportsWhenItCannotWrite) {
  EXPECT_THROW(EventLogWriter("/nonexistent/log.lcm"), std::runtime_error);
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EventLogWriter full("/dev/full");
  bool good = true;
  for (int i = 0; i < 10; ++i) good = full.write(i, "A", Bytes(100'000)) && good;
  EXPECT_FALSE(good);
}

}  // namespace
}  // namespace slam::event_log_test
