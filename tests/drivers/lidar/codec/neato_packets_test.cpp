// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/neato_packets.hpp"

#include <gtest/gtest.h>

namespace slam::neato::neato_packets_test {
namespace {

using Packet = std::vector<std::uint8_t>;

// Computed from the descriptions of the formats: no recorded packet of an XV-11 or LDS-01 of known origin is public.
const Packet kXv11 = {0xFA, 0xA0, 0x00, 0x4B, 0xE8, 0x03, 0xC8, 0x00, 0xED, 0x03, 0xC6,
                      0x00, 0x35, 0x80, 0x00, 0x00, 0xC4, 0x49, 0x0C, 0x00, 0x64, 0x3C};
const Packet kXv11Last = {0xFA, 0xF9, 0xA0, 0x4A, 0xF4, 0x01, 0x84, 0x03, 0xF5, 0x01, 0x85,
                          0x03, 0xF6, 0x01, 0x86, 0x03, 0xF7, 0x01, 0x87, 0x03, 0xAF, 0x0F};
const Packet kLds01 = {0xFA, 0xA0, 0xB8, 0x0B, 0xD0, 0x07, 0xE8, 0x03, 0x00, 0x00, 0xD1, 0x07, 0xE9, 0x03,
                       0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x34, 0x08, 0xDC, 0x05, 0x00, 0x00,
                       0x35, 0x08, 0xDD, 0x05, 0x00, 0x00, 0x36, 0x08, 0xDE, 0x05, 0x00, 0x00, 0xBF, 0xBF};
// Of a real Camsense X1 (Vidicon/camsense-X1, "a few data packets.txt"): 152.73 to 158.91 deg; and one without echoes.
const Packet kCamsense = {0x55, 0xAA, 0x03, 0x08, 0xEC, 0x4D, 0x2F, 0xC6, 0x7A, 0x06, 0x35, 0x7A,
                          0x06, 0x30, 0x7B, 0x06, 0x35, 0x7A, 0x06, 0x33, 0x79, 0x06, 0x34, 0x78,
                          0x06, 0x22, 0x08, 0x07, 0x09, 0xED, 0x06, 0x09, 0xBA, 0xC7, 0xDB, 0x39};
const Packet kCamsenseEmpty = {0x55, 0xAA, 0x03, 0x08, 0xEF, 0x4D, 0xB1, 0xC2, 0x00, 0x80, 0x00, 0x00,
                               0x80, 0x00, 0x00, 0x80, 0x00, 0x00, 0x80, 0x00, 0x00, 0x80, 0x00, 0x00,
                               0x80, 0x00, 0x00, 0x80, 0x00, 0x00, 0x80, 0x00, 0x33, 0xC4, 0xD1, 0x33};

std::vector<LidarNode> nodesOf(const LidarPackets& packets, const Packet& packet) {
  EXPECT_EQ(packets.size(LidarPackets::Bytes(packet).first(packets.head)), packet.size());
  EXPECT_TRUE(packets.good(packet));
  std::vector<LidarNode> nodes;
  packets.nodes(packet, nodes);
  return nodes;
}

TEST(NeatoPackets, OfAnXv11HaveFourDegrees) {
  const auto nodes = nodesOf(kXv11Packets, kXv11);
  ASSERT_EQ(nodes.size(), 4U);
  EXPECT_EQ(nodes[0].distance_q2, 4000U);
  EXPECT_EQ(nodes[1].angle_q6, 64);
  EXPECT_EQ(nodes[2].distance_q2, 0U) << "invalid, with an error code";
  EXPECT_EQ(nodes[3].distance_q2, 10000U) << "with a warning, which is not an error";
  EXPECT_EQ(nodesOf(kXv11Packets, kXv11Last)[3].angle_q6, 359 * 64);
}

TEST(NeatoPackets, OfAnLds01HaveSixDegrees) {
  const auto nodes = nodesOf(kLds01Packets, kLds01);
  ASSERT_EQ(nodes.size(), 6U);
  EXPECT_EQ(nodes[0].distance_q2, 4000U);
  EXPECT_EQ(nodes[2].distance_q2, 0U);
  EXPECT_EQ(nodes[5].distance_q2, 4U * 1502);
  Packet other = kLds01;
  other[40] = 0x12, other[41] = 0x34;
  EXPECT_TRUE(kLds01Packets.good(other)) << "another check, which is not known";
  other[7] = 0xFF;
  EXPECT_FALSE(kLds01Packets.good(other)) << "65 m";
}

TEST(NeatoPackets, OfACamsenseHaveEightSamples) {
  const auto nodes = nodesOf(kCamsensePackets, kCamsense);
  ASSERT_EQ(nodes.size(), 8U);
  EXPECT_NEAR(nodes.front().angle_q6 / 64.0, 152.73, 0.02);
  EXPECT_NEAR(nodes.back().angle_q6 / 64.0, 158.91, 0.02);
  EXPECT_EQ(nodes[0].distance_q2, 4U * 1658);
  for (const LidarNode& node : nodesOf(kCamsensePackets, kCamsenseEmpty)) EXPECT_EQ(node.distance_q2, 0U);
}

TEST(NeatoPackets, RefuseDamage) {
  for (std::size_t i = 2; i < kXv11.size(); ++i) {
    Packet packet = kXv11;
    packet[i] ^= 0x04;
    EXPECT_FALSE(kXv11Packets.good(packet)) << i;
  }
  Packet packet = kCamsense;
  packet[9] ^= 1;
  EXPECT_FALSE(kCamsensePackets.good(packet));
  packet = kLds01;
  packet[6] ^= 1;
  EXPECT_FALSE(kLds01Packets.good(packet));
}

}  // namespace
}  // namespace slam::neato::neato_packets_test
