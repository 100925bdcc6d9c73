// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/ldrobot_packets.hpp"

#include <gtest/gtest.h>

namespace slam::ldrobot::ldrobot_packets_test {
namespace {

using Packet = std::vector<std::uint8_t>;

// Example of the LD06's development manual: 2152 deg/s, 324.27 to 334.70 deg, first sample 224 mm.
const Packet kManual = {0x54, 0x2C, 0x68, 0x08, 0xAB, 0x7E, 0xE0, 0x00, 0xE4, 0xDC, 0x00, 0xE2, 0xD9, 0x00, 0xE5, 0xD5,
                        0x00, 0xE3, 0xD3, 0x00, 0xE4, 0xD0, 0x00, 0xE9, 0xCD, 0x00, 0xE4, 0xCA, 0x00, 0xE2, 0xC7, 0x00,
                        0xE9, 0xC5, 0x00, 0xE5, 0xC2, 0x00, 0xE5, 0xC0, 0x00, 0xE5, 0xBE, 0x82, 0x3A, 0x1A, 0x50};
// Of a real LD19, published in a student's notes: nothing in reach, 344.80 to 350.74 deg.
const Packet kEmpty = {0x54, 0x2C, 0x74, 0x08, 0xB0, 0x86, 0x00, 0x00, 0xD4, 0x00, 0x00, 0xD4, 0x00, 0x00, 0xD4, 0x00,
                       0x00, 0xD4, 0x00, 0x00, 0xD4, 0x00, 0x00, 0xD5, 0x00, 0x00, 0xD5, 0x00, 0x00, 0x49, 0x00, 0x00,
                       0x5F, 0x00, 0x00, 0xB0, 0x00, 0x00, 0xD2, 0x00, 0x00, 0xD4, 0x02, 0x89, 0x1E, 0x09, 0x1F};

std::vector<LidarNode> nodesOf(const LidarPackets& packets, const Packet& packet) {
  std::vector<LidarNode> nodes;
  packets.nodes(packet, nodes);
  return nodes;
}

TEST(LdrobotPackets, ReadTheManualsExample) {
  ASSERT_EQ(kPackets.size(kManual), kSize);
  ASSERT_TRUE(kPackets.good(kManual));
  const auto nodes = nodesOf(kPackets, kManual);
  ASSERT_EQ(nodes.size(), kSamples);
  EXPECT_NEAR(nodes.front().angle_q6 / 64.0, 324.27, 0.01);
  EXPECT_NEAR(nodes.back().angle_q6 / 64.0, 334.70, 0.01);
  EXPECT_NEAR(nodes[1].angle_q6 / 64.0, 324.27 + 10.43 / 11.0, 0.01);
  EXPECT_EQ(nodes.front().distance_q2, 4U * 224);
  EXPECT_EQ(nodes.front().quality, 228);
  EXPECT_EQ(nodes.back().distance_q2, 4U * 192);
}

TEST(LdrobotPackets, ReadARealUnitsPacketWithoutEchoes) {
  ASSERT_TRUE(kPackets.good(kEmpty));
  for (const LidarNode& node : nodesOf(kPackets, kEmpty)) EXPECT_EQ(node.distance_q2, 0U);
}

TEST(LdrobotPackets, RefuseEachDamagedByte) {
  for (std::size_t i = 2; i < kSize; ++i) {
    Packet packet = kManual;
    packet[i] ^= 0x10;
    EXPECT_FALSE(kPackets.good(packet)) << i;
  }
  EXPECT_EQ(kPackets.size(Packet{0x54, 0x2D}), 0U);
}

TEST(LdrobotPackets, RefuseAnglesThatCannotBe) {
  Packet packet = kManual;
  packet[4] = 0xFF, packet[5] = 0xFF;  // 655.35 deg
  packet.back() = crc8(LidarPackets::Bytes(packet).first(kSize - 1));
  EXPECT_FALSE(kPackets.good(packet));
  packet = kManual;
  packet[42] = 0, packet[43] = 0x50;  // 204.80 deg: most of a turn behind the first
  packet.back() = crc8(LidarPackets::Bytes(packet).first(kSize - 1));
  EXPECT_FALSE(kPackets.good(packet));
}

TEST(LdrobotPackets, OfAnLd08HaveTheShiftOfTheirDistance) {
  const auto plain = nodesOf(kPackets, kManual), shifted = nodesOf(kLd08Packets, kManual);
  EXPECT_NEAR((shifted[0].angle_q6 - plain[0].angle_q6) / 64.0, ld08Shift(224.0), 0.02);
  EXPECT_NEAR(ld08Shift(1000.0), -5.626, 0.001) << "atan((119.23 - 20.14) / 1005.9)";
  EXPECT_EQ(kLd08Packets.size(Packet{0x54, 0xEC}), kSize) << "its type is 1 or 7";
  EXPECT_EQ(nodesOf(kLd08Packets, kEmpty)[0].angle_q6, nodesOf(kPackets, kEmpty)[0].angle_q6)
      << "without an echo: none";
}

}  // namespace
}  // namespace slam::ldrobot::ldrobot_packets_test
