// SPDX-License-Identifier: BSD-3-Clause
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include "tools/bag_bytes.hpp"
#include "tools/convert/formats.hpp"
#include "tools/files.hpp"

namespace slam::auto_test {
namespace {

using namespace test;
using testing::HasSubstr;

constexpr std::int64_t kNow = 1'700'000'000'000'000;
constexpr std::size_t kMegabyte = std::size_t{1} << 20;
constexpr std::uint32_t kClaimed = 1U << 28;

/// Compressed by gzip: a beginning, and then a text again and again until so many bytes are there.
void writeGzip(const std::filesystem::path& file, const std::string& begin, const std::string& repeated,
               std::size_t bytes) {
  std::string block;
  while (block.size() < kMegabyte) block += repeated;
  gzFile out = gzopen(file.c_str(), "wb1");
  gzwrite(out, begin.data(), static_cast<unsigned>(begin.size()));
  for (std::size_t at = 0; at < bytes; at += block.size())
    gzwrite(out, block.data(), static_cast<unsigned>(block.size()));
  gzclose(out);
}

/// Big-endian numbers, as LCM has them.
std::string number(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i));
  return text;
}
std::string lcmEvent(const std::string& channel, std::uint32_t claimed, const std::string& data) {
  return number(0xEDA1DA01, 4) + number(0, 8) + number(kNow, 8) + number(channel.size(), 4) + number(claimed, 4) +
         channel + data;
}

void run(sqlite3* database, const char* query) {
  char* error = nullptr;
  if (sqlite3_exec(database, query, nullptr, nullptr, &error) == SQLITE_OK) return;
  throw std::runtime_error(error);
}
void writeDatabase(const std::filesystem::path& file, const std::vector<const char*>& queries) {
  sqlite3* database = nullptr;
  sqlite3_open(file.c_str(), &database);
  for (const char* const query : queries) run(database, query);
  sqlite3_close(database);
}
constexpr const char* kTopics =
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)";
constexpr const char* kOneTopic = "INSERT INTO topics VALUES(1, '/scan', 'sensor_msgs/msg/LaserScan', 'cdr')";
constexpr const char* kMessages =
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)";

std::vector<BagTopic> scans(const std::string& definition = {}, bool cdr = false) {
  return {{"/scan", std::string("sensor_msgs/") + (cdr ? "msg/" : "") + "LaserScan", definition}};
}
/// Types that hold a hundred of the next one each.
std::string endlessDefinition() {
  std::string text;
  for (int level = 0; level < 9; ++level) {
    if (level > 0) text += "====\nMSG: sensor_msgs/T" + std::to_string(level) + "\n";
    for (int i = 0; i < 100; ++i) text += "T" + std::to_string(level + 1) + " f" + std::to_string(i) + "\n";
  }
  return text + "====\nMSG: sensor_msgs/T9\n# nothing\n";
}
std::string scanOfManyClaimed(bool cdr) {
  Wire wire(cdr);
  wire.header(kNow, "laser").put(-1.0F).put(1.0F).put(0.5F).put(0.001F).put(0.1F).put(0.1F).put(10.0F);
  return wire.put(kClaimed).put(1.0F).bytes();
}
std::string mcapChunk(std::uint64_t claimed, const std::string& compression, const std::string& data) {
  return mcapRecord(6, Wire()
                           .put(std::uint64_t{0})
                           .put(std::uint64_t{0})
                           .put(claimed)
                           .put(std::uint32_t{0})
                           .text(compression)
                           .put(static_cast<std::uint64_t>(data.size()))
                           .raw(data)
                           .bytes());
}
std::string bagChunk(const std::string& compression, std::uint32_t claimed, const std::string& data) {
  return bagRecord(bagField("compression", compression) + bagField("op", "\5") + bagField("size", rawNumber(claimed)),
                   data);
}

/// A recording that somebody made to do harm, or a damage that looks like it.
struct Hostile {
  const char* name;
  std::function<void(const std::filesystem::path&)> write;
  const char* reason;  // why it is refused
};

const std::vector<Hostile>& hostileRecordings() {
  using Path = const std::filesystem::path&;
  static const auto text = [](const std::string& content) {
    return [content](Path file) { std::ofstream(file, std::ios::binary) << content; };
  };
  static const std::string bag = "#ROSBAG V2.0\n", mcap = "\x89MCAP0\r\n";
  static const std::string zeros(64 * kMegabyte, '\0');
  static const std::vector<Hostile> all = {
      {"GzipLineWithoutEnd", [](Path file) { writeGzip(file, "FLASER 180 ", "1.0 ", 64 * kMegabyte); }, "longer than"},
      {"GzipLineOfZeros", [](Path file) { writeGzip(file, "", std::string(1, '\0'), 64 * kMegabyte); }, "longer than"},
      {"LineWithoutEnd", text("1.0" + std::string(3 * kMegabyte, '7')), "longer than"},
      {"RowOfManyColumns", [](Path file) { writeGzip(file, "1.0", ",2.5", 2 * kMegabyte); }, "longer than"},
      {"GzipOfEmptyLines", [](Path file) { writeGzip(file, "FLASER\n", "\n", 300 * kMegabyte); }, "200 times its size"},
      {"GzipOfComments", [](Path file) { writeGzip(file, "FLASER\n", "#\n", 300 * kMegabyte); }, "200 times its size"},
      {"FlaserOfManyBeams", text("FLASER 268435456 1 2 3 0 0 0 0 0 0 1 host 1\n"), "number of beams"},
      {"FlaserOf1e300Beams", text("FLASER 1e300 1 2 3 0 0 0 0 0 0 1 host 1\n"), "number of beams"},
      {"RobotLaserOfManyBeams", text("ROBOTLASER1 0 -1.57 3.14 0.0174 80 0.01 0 268435456 1 1\n"), "number of beams"},
      {"TableOfHugeNumbers", text("1e308,1e308,1e308,1e308\n1e308,1e308,1e308,1e308\n"), "no metres"},
      {"LcmRecordOf2To28", text(lcmEvent("SLAM_SCAN", kClaimed, "none")), "without scans"},
      {"GzipLcmRecordOf2To28",
       [](Path file) {
         writeGzip(file, lcmEvent("SLAM_SCAN", kClaimed, ""), std::string(1, '\0'), 300 * kMegabyte);
       },
       "without scans"},
      {"LcmRecordsOf2To25",
       [](Path file) {
         std::string log;
         for (int i = 0; i < 1000; ++i) log += lcmEvent("SLAM_SCAN", 1U << 25, std::string(100, 'x'));
         std::ofstream(file, std::ios::binary) << log;
       },
       "without scans"},
      {"MbotScanOfManyBeams",
       text(lcmEvent("LIDAR", 20, number(0x89dc5b879a5056cf, 8) + number(kNow, 8) + number(kClaimed, 4))),
       "no lidar scan"},
      {"BagHeaderOf2To28", text(bag + rawNumber(kClaimed) + "op=\2"), "no lidar scan"},
      {"BagDataOf2To28", text(bag + Wire().text(bagField("op", "\5")).put(kClaimed).bytes()), "no lidar scan"},
      {"BagChunksOfZeros",
       [](Path file) {
         const std::string chunk = bagChunk("bz2", kClaimed, packed("bz2", zeros.substr(0, 20 * kMegabyte)));
         std::string content = bag;
         for (int i = 0; i < 40; ++i) content += chunk;
         std::ofstream(file, std::ios::binary) << content;
       },
       "200 times its size"},
      {"BagChunkInChunk", text(bag + bagChunk("none", 9, bagChunk("none", 9, bagChunk("none", 9, "")))),
       "no lidar scan"},
      {"BagScanOfManyBeams",
       text(rosBag(scans(), std::vector<BagMessage>(50, {0, kNow, scanOfManyClaimed(false)}))), "do not decode"},
      {"BagOfEndlessTypes", text(rosBag(scans(endlessDefinition()), {{0, kNow, scanBytes(false, kNow, {1, 2})}})),
       "lacks"},
      {"McapChunksOfZeros",
       [](Path file) {
         const std::string chunk = mcapChunk(zeros.size(), "zstd", packed("zstd", zeros));
         std::string content = mcap;
         for (int i = 0; i < 200; ++i) content += chunk;
         std::ofstream(file, std::ios::binary) << content;
       },
       "200 times its size"},
      {"McapChunksOfZerosLz4",
       [](Path file) {
         const std::string chunk = mcapChunk(zeros.size(), "lz4", packed("lz4", zeros.substr(0, 32 * kMegabyte)));
         std::string content = mcap;
         for (int i = 0; i < 60; ++i) content += chunk;
         std::ofstream(file, std::ios::binary) << content;
       },
       "200 times its size"},
      {"McapChunkOf2To62", text(mcap + mcapChunk(std::uint64_t{1} << 62, "", "none")), "no lidar scan"},
      {"McapMessageOf2To28",
       text(mcap + Wire().put(std::uint8_t{5}).put(std::uint64_t{kClaimed}).put(std::uint16_t{1}).bytes()),
       "no lidar scan"},
      {"McapOfEndlessTypes",
       text(mcapFile(scans(endlessDefinition(), true), {{0, kNow, scanBytes(true, kNow, {1, 2})}})), "lacks"},
      {"Db3TopicsAreAView",
       [](Path file) {
         writeDatabase(file, {"CREATE VIEW topics AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT 1 FROM n) "
                              "SELECT id, '/scan' AS name, 'sensor_msgs/msg/LaserScan' AS type, 'cdr' AS "
                              "serialization_format FROM n WHERE id > 1",
                              kMessages});
       },
       "no table topics"},
      {"Db3MessagesAreAView",
       [](Path file) {
         writeDatabase(file, {kTopics, kOneTopic,
                              "CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM "
                              "n) SELECT id, 1 AS topic_id, 5 AS timestamp, x'00' AS data FROM n"});
       },
       "no table messages"},
      {"Db3DefinitionsAreAView",
       [](Path file) {
         writeDatabase(file, {kTopics, kOneTopic, kMessages,
                              "CREATE VIEW message_definitions AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT 1 "
                              "FROM n) SELECT '' AS topic_type, '' AS encoding, '' AS encoded_message_definition FROM n "
                              "WHERE id > 1"});
       },
       "no lidar scan"},
      {"Db3MessagesAreComputed",
       [](Path file) {
         writeDatabase(file, {kTopics, kOneTopic,
                              "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data "
                              "BLOB AS (zeroblob(60000000)))",
                              "INSERT INTO messages WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n "
                              "LIMIT 2000) SELECT id, 1, 5 FROM n"});
       },
       "200 times its size"},
      {"Db3MessagesUnpackToZeros",
       [](Path file) {
         const std::string message = packed("zstd", zeros);
         writeDb3(file, scans({}, true), std::vector<BagMessage>(200, {0, kNow, message}));
       },
       "200 times its size"},
  };
  return all;
}

class HostileRecording : public testing::TestWithParam<Hostile> {};

/// In a process of its own, whose memory and processor time are bounded.
TEST_P(HostileRecording, IsRefusedWithTheReasonInBoundedTimeAndMemory) {
  const Folder folder;
  GetParam().write(folder / "in");
  EXPECT_LT(std::filesystem::file_size(folder / "in"), 16 * kMegabyte);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    const rlimit seconds{60, 60};  // of the processor; a second does
    setrlimit(RLIMIT_CPU, &seconds);
    int code = 0;
    std::string words;
    try {
      convertAny(folder / "in", folder / "out.lcm");
    } catch (const std::runtime_error& error) {
      words = error.what();
      code = 1;
    } catch (const std::exception& error) {
      words = error.what();
      code = 2;
    }
    folder.write("words", words);
    _exit(code);
  }
  int status = 0;
  rusage usage{};
  ASSERT_EQ(wait4(child, &status, 0, &usage), child);
  ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_THAT(contentOf(folder / "words"), HasSubstr(GetParam().reason));
  EXPECT_FALSE(std::filesystem::exists(folder / "out.lcm"));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  constexpr long kMostMemory = 400 * 1024;  // [kB] with that of the test itself, which holds the zeros
  EXPECT_LT(usage.ru_maxrss, kMostMemory);
#endif
}

INSTANTIATE_TEST_SUITE_P(Any, HostileRecording, testing::ValuesIn(hostileRecordings()),
                         [](const auto& hostile) { return hostile.param.name; });

TEST(RecordingsOfOtherFormats, AreNotRecognisedAndWhatIsReadIsReported) {
  const Folder folder;
  const auto refused = [&](const std::string& content) {
    return refusalOf([&] { convertAny(folder.write("in.log", content), folder / "out.lcm"); });
  };
  std::string g2o, edges, player, relations;
  for (int i = 0; i < 50; ++i) {
    const std::string n = std::to_string(i), next = std::to_string(i + 1);
    g2o += "VERTEX_SE2 " + n + " 0.5 1.25 0.1\n";
    edges += "EDGE_SE2 " + n + " " + next + " 0.5 0.01 0.1 500 0 0 500 0 5000\n";
    player += "## comment\n12345." + n + " host 6665 position 00 0.5 1.25 0.1\nlaser " + n + " 1.0 2.0 3.0 4.0\n";
    relations += "scan " + n + " 1.5 1.5 1.5 1.5 1.5 1.5 1.5 1.5 1.5 1.5\n";
  }
  for (const std::string& content : {g2o, edges, g2o + edges, player, relations, std::string("\x07CMRPT\0\1\2", 9)}) {
    EXPECT_THAT(refused(content), testing::AllOf(HasSubstr("not recognised"), HasSubstr("FLASER"), HasSubstr(".mcap")));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "out.lcm"));
}

}  // namespace
}  // namespace slam::auto_test
