// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/ldrobot_packets.hpp"

#include <cmath>
#include <numbers>

namespace slam::ldrobot {
namespace {

using Bytes = LidarPackets::Bytes;

constexpr std::size_t kFirst = 4, kSample = 6, kLast = 42;
constexpr long kTurn = 36000, kWidest = 6000;  // [0.01 deg] of a packet; 1880 at the slowest rate and fastest turn

long width(Bytes packet) {
  return (static_cast<long>(u16At(packet, kLast)) - static_cast<long>(u16At(packet, kFirst)) + kTurn) % kTurn;
}

std::size_t size(Bytes head) { return head[0] == 0x54 && head[1] == 0x2C ? kSize : 0; }
std::size_t ld08Size(Bytes head) { return head[0] == 0x54 && (head[1] & 0x1F) == kSamples ? kSize : 0; }

bool good(Bytes packet) {
  return crc8(packet.first(kSize - 1)) == packet[kSize - 1] && u16At(packet, kFirst) < kTurn &&
         u16At(packet, kLast) < kTurn && width(packet) < kWidest;
}

/// @param shift [deg] clockwise of a distance [mm]
template <typename Shift>
void appendNodes(Bytes packet, std::vector<LidarNode>& nodes, Shift&& shift) {
  const auto first = static_cast<double>(u16At(packet, kFirst));
  const double step = static_cast<double>(width(packet)) / (kSamples - 1.0);
  for (std::size_t i = 0; i < kSamples; ++i) {
    const unsigned distance = u16At(packet, kSample + 3 * i);
    const double angle = 0.01 * (first + static_cast<double>(i) * step) + (distance > 0 ? shift(distance) : 0.0);
    nodes.push_back({.angle_q6 = nodeAngle(std::lround(64.0 * angle)),
                     .distance_q2 = 4 * distance,
                     .quality = packet[kSample + 3 * i + 2]});
  }
}

void nodes(Bytes packet, std::vector<LidarNode>& out) {
  appendNodes(packet, out, [](double) { return 0.0; });
}
void ld08Nodes(Bytes packet, std::vector<LidarNode>& out) { appendNodes(packet, out, ld08Shift); }

}  // namespace

std::uint8_t crc8(Bytes bytes) {
  std::uint8_t crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = static_cast<std::uint8_t>((crc & 0x80) != 0 ? crc << 1 ^ 0x4D : crc << 1);
  }
  return crc;
}

double ld08Shift(double distance_mm) {
  constexpr double kSlope = 0.11923, kAhead = 5.9, kAside = -20.14;  // [1], [mm], [mm]
  return -std::atan((kSlope * distance_mm + kAside) / (distance_mm + kAhead)) * 180.0 / std::numbers::pi;
}

const LidarPackets kPackets{2, kSize, size, good, nodes};
const LidarPackets kLd08Packets{2, kSize, ld08Size, good, ld08Nodes};

}  // namespace slam::ldrobot
