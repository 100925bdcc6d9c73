// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/roboclaw.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace slam::roboclaw::roboclaw_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytesOf(const Outgoing& out) { return {out.bytes().begin(), out.bytes().end()}; }

// Computed by the published library: counts 1000 and -100 of address 80h; both speeds 1000 and -1000.
const Bytes kCounts{0x00, 0x00, 0x03, 0xE8, 0xFF, 0xFF, 0xFF, 0x9C, 0xFA, 0x51};
const Bytes kSpeeds{0x80, 0x25, 0x00, 0x00, 0x03, 0xE8, 0xFF, 0xFF, 0xFC, 0x18, 0x82, 0x90};

TEST(Roboclaw, AsksAndReadsAsThePublishedLibraryDoes) {
  EXPECT_EQ(bytesOf(askCounts(0x80)), (Bytes{0x80, 0x4E}));
  EXPECT_EQ(bytesOf(askVersion(0x83)), (Bytes{0x83, 0x15}));
  EXPECT_EQ(bytesOf(encodeSpeeds(0x80, {1000, -1000})), kSpeeds);
  EXPECT_EQ(parseSpeeds(kSpeeds), (std::array<std::int32_t, 2>{1000, -1000}));
  EXPECT_EQ(parseCounts(0x80, kCounts), (std::array<std::uint32_t, 2>{1000, static_cast<std::uint32_t>(-100)}));
  EXPECT_EQ(bytesOf(encodeCounts(0x80, {1000, static_cast<std::uint32_t>(-100)})), kCounts);
}

TEST(Roboclaw, SetsItsTimeoutByAPacketWithAChecksum) {
  const Bytes packet = bytesOf(encodeTimeout(0x80, 5));
  EXPECT_EQ(Bytes(packet.begin(), packet.begin() + 3), (Bytes{0x80, 14, 5}));
  EXPECT_EQ(sizeOf(Bytes{0x80, 14}), packet.size());
  EXPECT_EQ(parseTimeout(packet), 5);
  EXPECT_FALSE(parseTimeout(kSpeeds));
  for (std::size_t i = 1; i < packet.size(); ++i) {
    Bytes damaged = packet;
    damaged[i] ^= 0x01;
    EXPECT_FALSE(parseTimeout(damaged)) << i;
  }
}

TEST(Roboclaw, RefusesEachDamagedByteAndTheAnswerOfAnotherAddress) {
  EXPECT_FALSE(parseCounts(0x81, kCounts));
  for (std::size_t i = 0; i < kCounts.size(); ++i) {
    Bytes damaged = kCounts;
    damaged[i] ^= 0x20;
    EXPECT_FALSE(parseCounts(0x80, damaged)) << i;
  }
  for (std::size_t i = 1; i < kSpeeds.size(); ++i) {
    Bytes damaged = kSpeeds;
    damaged[i] ^= 0x01;
    EXPECT_FALSE(parseSpeeds(damaged)) << i;
  }
  EXPECT_FALSE(parseCounts(0x80, Bytes(9)));
  EXPECT_FALSE(parseSpeeds(Bytes{0x80, 0x25}));
}

TEST(Roboclaw, FindsTheEndOfAVersionBehindWhateverCame) {
  const Bytes version = bytesOf(encodeVersion(0x80));
  EXPECT_TRUE(endsWithVersion(0x80, version));
  EXPECT_FALSE(endsWithVersion(0x81, version));
  Bytes behind = kCounts;  // of a request that was given up
  behind.insert(behind.end(), version.begin(), version.end());
  for (std::size_t size = 0; size < behind.size(); ++size)
    EXPECT_FALSE(endsWithVersion(0x80, {behind.data(), size})) << size;
  EXPECT_TRUE(endsWithVersion(0x80, behind));
  for (std::size_t i = 0; i < version.size(); ++i) {
    Bytes damaged = version;
    damaged[i] ^= 0x04;
    EXPECT_FALSE(endsWithVersion(0x80, damaged)) << i;
  }
  std::mt19937 random(2);
  for (int i = 0; i < 20000; ++i) {
    Bytes noise(random() % 60);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
    EXPECT_FALSE(endsWithVersion(0x80, noise));
  }
}

TEST(Roboclaw, HasTheSizeOfAPacketByItsHead) {
  EXPECT_EQ(sizeOf(Bytes{0x80}), 2U);
  EXPECT_EQ(sizeOf(Bytes{0x87, 0x4E}), 2U);
  EXPECT_EQ(sizeOf(Bytes{0x80, 0x25}), 12U);
  EXPECT_EQ(sizeOf(Bytes{0x88}), 0U);
  EXPECT_EQ(sizeOf(Bytes{0x80, 0x00}), 0U);
}

}  // namespace
}  // namespace slam::roboclaw::roboclaw_test
