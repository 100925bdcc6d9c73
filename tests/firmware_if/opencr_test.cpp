// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/opencr.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace slam::opencr::opencr_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytesOf(const Outgoing& out) { return {out.bytes().begin(), out.bytes().end()}; }

std::vector<Packet> packetsIn(const Bytes& bytes, Decoder& decoder) {
  std::vector<Packet> packets;
  for (const std::uint8_t byte : bytes) {
    decoder.push(byte, [&](std::span<const std::uint8_t> frame) {
      if (const auto packet = parse(frame)) packets.push_back(*packet);
    });
  }
  return packets;
}
std::vector<Packet> packetsIn(const Outgoing& out) {
  Decoder decoder;
  return packetsIn(bytesOf(out), decoder);
}

// The maker's example of a ping of servo 1 proves the checksum.
TEST(Opencr, HasTheChecksumOfTheMakersExample) {
  const Bytes example{0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x01, 0x19, 0x4E};
  EXPECT_TRUE(Format::isGood(example));
  for (std::size_t i = 0; i < example.size(); ++i) {
    Bytes damaged = example;
    damaged[i] ^= 0x40;
    EXPECT_FALSE(Format::isGood(damaged)) << i;
  }
}

// Computed by the maker's description.
TEST(Opencr, WritesItsQuestionsAsTheyAreDescribed) {
  EXPECT_EQ(bytesOf(ping()), (Bytes{0xFF, 0xFF, 0xFD, 0x00, 0xC8, 0x03, 0x00, 0x01, 0x3B, 0xFA}));
  EXPECT_EQ(bytesOf(beat(1)), (Bytes{0xFF, 0xFF, 0xFD, 0x00, 0xC8, 0x06, 0x00, 0x03, 0x13, 0x00, 0x01, 0x37, 0xA7}));
  const Bytes read = bytesOf(readTable());
  EXPECT_THAT(Bytes(read.begin() + 5, read.end() - 2), testing::ElementsAre(7, 0, 2, 10, 0, 134, 0));
  const auto speeds = packetsIn(encodeSpeeds(0.10, -1.5));
  ASSERT_EQ(speeds.size(), 1U);
  EXPECT_TRUE(isForBoard(speeds[0]));
  EXPECT_EQ(parseSpeeds(speeds[0]), (std::array{0.10, -1.5}));
  EXPECT_EQ(parseBeat(packetsIn(beat(77))[0]), 77);
  EXPECT_FALSE(parseBeat(speeds[0]));
}

TEST(Opencr, ReadsWhatItsBoardAnswers) {
  const Table table{
      .millis = 4000000000U, .battery = 11.84, .bumped = true, .turn_rate = -0.25F, .counts = {0xFFFFFF00U, 12345}};
  const auto packets = packetsIn(encodeTable(table));
  ASSERT_EQ(packets.size(), 1U);
  const auto read = parseTable(packets[0]);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->millis, table.millis);
  EXPECT_NEAR(read->battery, table.battery, 1e-9);
  EXPECT_EQ(read->turn_rate, table.turn_rate);
  EXPECT_EQ(read->counts, table.counts);
  EXPECT_TRUE(read->bumped);
  EXPECT_FALSE(parseTable(packetsIn(encodeTable({}))[0])->bumped);
  EXPECT_TRUE(isPong(packetsIn(encodePong())[0]));
  EXPECT_TRUE(isDone(packetsIn(encodeDone())[0]));
  EXPECT_FALSE(isDone(packets[0]));
  EXPECT_FALSE(parseTable(packetsIn(encodePong())[0]));
  const Table bad{.turn_rate = std::numeric_limits<float>::quiet_NaN()};
  EXPECT_FALSE(parseTable(packetsIn(encodeTable(bad))[0]));
}

TEST(Opencr, StuffsAHeadThatStandsInItsValues) {
  const Table table{.counts = {0xFDFFFF00U, 0xFFFDFFFFU}};  // FF FF FD twice
  const Outgoing frame = encodeTable(table);
  EXPECT_EQ(frame.size(), encodeTable({}).size() + 2);
  const auto packets = packetsIn(frame);
  ASSERT_EQ(packets.size(), 1U);
  EXPECT_EQ(parseTable(packets[0])->counts, table.counts);
}

TEST(Opencr, IsReadBehindDamage) {
  const Bytes good = bytesOf(encodeTable({.millis = 5, .counts = {1, 2}}));
  std::mt19937 random(8);
  for (int i = 0; i < 500; ++i) {
    Decoder decoder;
    Bytes bytes = good;
    bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    for (int k = 0; k < 3; ++k) bytes.insert(bytes.end(), good.begin(), good.end());
    const auto packets = packetsIn(bytes, decoder);
    ASSERT_GE(packets.size(), 1U) << "a false head holds at most 256 bytes";
    EXPECT_TRUE(parseTable(packets.back()));
  }
}

}  // namespace
}  // namespace slam::opencr::opencr_test
