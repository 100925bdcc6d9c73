// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/lc02.hpp"

#include <gtest/gtest.h>
#include <random>

#include "bus/packets.hpp"

namespace slam::lc02_test {
namespace {

using test::deadlyFragment;
using test::fragmentOf;
using test::packetOf;
using Bytes = std::vector<std::uint8_t>;

/// In memory of exactly its size, so that the address sanitizer sees a read behind the end.
Bytes cut(const Bytes& packet, std::size_t size) {
  return {packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(size)};
}

TEST(Lc02, StaysInsideAnyBytes) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> byte(0, 255), few(0, 90);
  int messages = 0, fragments = 0;
  for (int i = 0; i < 200'000; ++i) {
    Bytes bytes(static_cast<std::size_t>(few(random)));
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(byte(random) % 4 == 0 ? 0 : byte(random));
    const char magic[] = {'L', 'C', '0', static_cast<char>('2' + byte(random) % 2)};
    for (std::size_t k = 0; k < std::min<std::size_t>(bytes.size(), 4); ++k)
      bytes[k] = static_cast<std::uint8_t>(magic[k]);
    const Packet packet = parsePacket(bytes);
    messages += packet.kind == Packet::kMessage;
    fragments += packet.kind == Packet::kFragment;
    ASSERT_LE(packet.channel.size(), 63U);
    ASSERT_EQ(packet.channel.find('\0'), std::string_view::npos);
    if (packet.kind != Packet::kMessage) {
      ASSERT_TRUE(packet.data.empty());
      continue;
    }
    ASSERT_EQ(packet.data.data() + packet.data.size(), bytes.data() + bytes.size());
    ASSERT_EQ(8 + packet.channel.size() + 1 + packet.data.size(), bytes.size());
  }
  EXPECT_GT(messages, 1000);
  EXPECT_GT(fragments, 1000);
}

TEST(Lc02, ReadsAMessageWhateverItsSizeAndSequence) {
  for (const std::size_t size : {0U, 1U, 100U, 65000U}) {
    const Bytes message(size, 0x5A);
    const Bytes bytes = packetOf("SLAM_COMMAND", message, 0xFFFFFFFF - static_cast<std::uint32_t>(size));
    const Packet packet = parsePacket(bytes);
    EXPECT_EQ(packet.kind, Packet::kMessage);
    EXPECT_EQ(packet.channel, "SLAM_COMMAND");
    EXPECT_EQ(Bytes(packet.data.begin(), packet.data.end()), message);
  }
}

TEST(Lc02, WritesWhatItReads) {
  Bytes packet(5, 1);
  for (const std::size_t size : {0U, 1U, 100U, 65000U}) {
    const Bytes message(size, 0x5A);
    writePacket("SLAM_COMMAND", message, packet);
    EXPECT_EQ(packet, packetOf("SLAM_COMMAND", message));
  }
}

TEST(Lc02, TruncatedInItsHeadOrNameIsNoPacket) {
  const std::string channel = "SLAM_SCAN";
  const Bytes message = packetOf(channel, Bytes(5, 1)), fragment = fragmentOf({100, 0, 0, 2}, channel, 5);
  for (std::size_t size = 0; size < 8 + channel.size() + 1; ++size) {
    EXPECT_EQ(parsePacket(cut(message, size)).kind, Packet::kOther) << size;
  }
  for (std::size_t size = 8 + channel.size() + 1; size <= message.size(); ++size) {
    EXPECT_EQ(parsePacket(cut(message, size)).data.size(), size - (8 + channel.size() + 1));
  }
  for (std::size_t size = 0; size < 20 + channel.size() + 1; ++size) {
    EXPECT_EQ(parsePacket(cut(fragment, size)).kind, Packet::kOther) << size;
  }
}

TEST(Lc02, NamesHaveAtMost63Characters) {
  EXPECT_EQ(parsePacket(packetOf(std::string(63, 'x'), Bytes(9, 0))).channel, std::string(63, 'x'));
  EXPECT_EQ(parsePacket(packetOf(std::string(64, 'x'), Bytes(9, 0))).kind, Packet::kOther);
  EXPECT_EQ(parsePacket(packetOf("", Bytes(9, 0))).kind, Packet::kMessage);
}

TEST(Lc02, DistinguishesFragmentsFromMessages) {
  const Bytes deadly = deadlyFragment("SLAM_COMMAND"), middle = fragmentOf({1000, 500, 256, 257}, "", 100);
  const Packet first = parsePacket(deadly);
  EXPECT_EQ(first.kind, Packet::kFragment);
  EXPECT_EQ(first.channel, "SLAM_COMMAND");
  EXPECT_TRUE(first.data.empty());
  const Packet later = parsePacket(middle);
  EXPECT_EQ(later.kind, Packet::kFragment);
  EXPECT_TRUE(later.channel.empty());
}

TEST(Lc02, OtherMagicIsNoPacket) {
  Bytes packet = packetOf("SLAM_SCAN", Bytes(30, 0));
  for (std::size_t i = 0; i < 4; ++i) {
    Bytes other = packet;
    other[i] ^= 0x40;
    EXPECT_EQ(parsePacket(other).kind, Packet::kOther);
  }
}

}  // namespace
}  // namespace slam::lc02_test
