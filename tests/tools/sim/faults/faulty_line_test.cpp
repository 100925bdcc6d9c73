// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/faults/faulty_line.hpp"

#include <algorithm>
#include <filesystem>
#include <gmock/gmock.h>
#include <unistd.h>

namespace slam::sim::faulty_line_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

const fs::path kLink = fs::path(testing::TempDir()) / ("line_" + std::to_string(getpid()));
constexpr Timestamp kNow{100s};

std::vector<std::uint8_t> readFrom(ByteStream& host) {
  std::vector<std::uint8_t> bytes(16);
  bytes.resize(host.read(bytes, 2s).size);
  return bytes;
}

TEST(FaultyLine, CarriesBytesBothWays) {
  FaultyLine line(kLink);
  OpenedPort host = openPort(kLink, 115200);
  ASSERT_TRUE(host.stream) << host.problem.words();
  line.send({1, 2}, kNow);
  EXPECT_THAT(readFrom(*host.stream), testing::ElementsAre(1, 2));
  const std::vector<std::uint8_t> request{0xA5, 0x50};
  ASSERT_TRUE(host.stream->write(request));
  EXPECT_EQ(line.receive(2s), request);
}

TEST(FaultyLine, IsUnderstoodAtItsBaudRateAlone) {
  FaultyLine line(kLink);
  ASSERT_TRUE(line.inject("baud", 460800));
  EXPECT_FALSE(line.inject("baud", -1));
  const std::vector<std::uint8_t> sent(64, 0x54), request{0xA5, 0x50};
  {
    OpenedPort wrong = openPort(kLink, 115200);
    ASSERT_TRUE(wrong.stream) << wrong.problem.words();
    line.send(sent, kNow);
    std::vector<std::uint8_t> bytes(64);
    bytes.resize(wrong.stream->read(bytes, 2s).size);
    EXPECT_GT(bytes.size(), 10U);
    EXPECT_LT(std::count(bytes.begin(), bytes.end(), 0x54), 5);
    ASSERT_TRUE(wrong.stream->write(request));
    EXPECT_TRUE(line.receive(2s).empty());
  }
  OpenedPort right = openPort(kLink, 460800);
  ASSERT_TRUE(right.stream) << right.problem.words();
  line.send({1, 2}, kNow);
  EXPECT_THAT(readFrom(*right.stream), testing::ElementsAre(1, 2));
}

TEST(FaultyLine, HangsUpWhenUnpluggedAndIsAnotherPortWhenPluggedAgain) {
  FaultyLine line(kLink);
  OpenedPort host = openPort(kLink, 115200);
  ASSERT_TRUE(host.stream) << host.problem.words();
  ASSERT_TRUE(line.inject("unplug", 1));
  std::vector<std::uint8_t> bytes(16);
  EXPECT_EQ(host.stream->read(bytes, 2s).status, ReadResult::kClosed);
  EXPECT_FALSE(openPort(kLink, 115200).stream);
  line.send({1}, kNow);  // into the air
  EXPECT_TRUE(line.receive(1ms).empty());

  ASSERT_TRUE(line.inject("unplug", 0));
  OpenedPort again = openPort(kLink, 115200);
  ASSERT_TRUE(again.stream) << again.problem.words();
  line.send({5}, kNow);
  EXPECT_THAT(readFrom(*again.stream), testing::ElementsAre(5));
}

}  // namespace
}  // namespace slam::sim::faulty_line_test
