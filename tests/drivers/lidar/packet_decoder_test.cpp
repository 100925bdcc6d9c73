// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/packet_decoder.hpp"

#include <gtest/gtest.h>
#include <random>

#include "drivers/lidar/lidar_facts.hpp"
#include "tools/sim/lidar/packet_emulator.hpp"

namespace slam::packet_decoder_test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr Timestamp kStart{100s};

class PacketDecoders : public testing::TestWithParam<const char*> {
 protected:
  Bytes stream(Duration time) {
    sim::PacketEmulator unit([](Timestamp, double) { return 2.0; }, GetParam());
    Bytes bytes, answers;
    unit.receive(Bytes{0xA5, 0x60, 0xF0, 0x0F, 'b'}, kStart, answers);  // the commands that begin a scan
    for (Timestamp now = kStart; now < kStart + time; now += 1ms) unit.stream(now, bytes);
    return bytes;
  }
  static std::vector<TimedNode> nodesOf(PacketDecoder& decoder, std::span<const std::uint8_t> bytes) {
    std::vector<TimedNode> nodes;
    for (const std::uint8_t byte : bytes) decoder.push(byte, nodes);
    return nodes;
  }

  const LidarFacts& facts_ = *findLidar(GetParam());
  double byte_time_ = 10.0 / facts_.baud;
  PacketDecoder decoder_{*facts_.packets, 1.0 / facts_.sample_rate, byte_time_};
};

TEST_P(PacketDecoders, ReadBehindEachDamage) {
  const Bytes good = stream(3s);
  const std::size_t whole = nodesOf(decoder_, good).size();
  ASSERT_GT(whole, 1000U);
  EXPECT_EQ(decoder_.rejects(), 0);
  std::mt19937 random(4);
  Bytes damaged = good;
  constexpr int kDamages = 20;
  for (int i = 0; i < kDamages; ++i) {
    const auto at = damaged.begin() + static_cast<std::ptrdiff_t>(random() % damaged.size());
    if (i % 3 == 0) damaged.erase(at);
    if (i % 3 == 1) damaged.insert(at, static_cast<std::uint8_t>(random()));
    if (i % 3 == 2) *at ^= static_cast<std::uint8_t>(1 + random() % 255);
  }
  PacketDecoder decoder(*facts_.packets, 1.0 / facts_.sample_rate, byte_time_);
  const std::size_t most = facts_.packets->longest;  // nodes that one damage may cost
  const std::size_t left = nodesOf(decoder, damaged).size();
  EXPECT_GE(left + kDamages * most, whole);
  EXPECT_LE(left, whole);
  EXPECT_GT(decoder.rejects(), kDamages / 4);
}

TEST_P(PacketDecoders, BeginInTheMiddleOfAPacket) {
  const Bytes good = stream(1s);
  for (const std::size_t cut : {1U, 5U, 21U}) {
    decoder_.reset();
    EXPECT_GT(nodesOf(decoder_, std::span(good).subspan(cut)).size(), 500U);
  }
}

TEST_P(PacketDecoders, StartATurnOncePerTurn) {
  int starts = 0;
  for (const TimedNode& timed : nodesOf(decoder_, stream(3s))) starts += timed.node.start;
  EXPECT_NEAR(starts, 3.0 * sim::findPacketFormat(GetParam())->turn_rate, 1.5);
}

TEST_P(PacketDecoders, CountWhatWasLostWithABadPacket) {
  Bytes bytes = stream(1s);
  std::vector<TimedNode> nodes;
  int lost = 0;
  bytes[bytes.size() / 2] ^= 0x55;
  for (const std::uint8_t byte : bytes) {
    decoder_.push(byte, nodes);
    lost += decoder_.lost();
  }
  EXPECT_GT(lost, 0);
  EXPECT_LE(lost, static_cast<int>(facts_.packets->longest));
}

TEST(PacketDecoder, SpendsNoPacketOnAHeadThatStandsTwice) {
  sim::PacketEmulator unit([](Timestamp, double) { return 2.0; }, "ld06");
  Bytes bytes{0x54};  // and then 54 2C: the maker's own parser loses this packet
  for (Timestamp now = kStart; bytes.size() < 60; now += 1ms) unit.stream(now, bytes);
  const LidarFacts& facts = *findLidar("ld06");
  PacketDecoder decoder(*facts.packets, 1.0 / facts.sample_rate, 10.0 / facts.baud);
  std::vector<TimedNode> nodes;
  for (const std::uint8_t byte : bytes) decoder.push(byte, nodes);
  EXPECT_EQ(nodes.size(), 12U);
}

INSTANTIATE_TEST_SUITE_P(Of, PacketDecoders, testing::ValuesIn([] {
                           std::vector<const char*> drivers;
                           for (const LidarFacts& row : lidarTable()) drivers.push_back(row.driver);
                           return drivers;
                         }()),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace slam::packet_decoder_test
