// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/neato_packets.hpp"

#include <algorithm>
#include <cmath>

namespace slam::neato {
namespace {

using Bytes = LidarPackets::Bytes;

constexpr std::size_t kXv11Size = 22, kLds01Size = 42, kCamsenseSize = 36;
constexpr unsigned kFirstIndex = 0xA0;
constexpr unsigned kNoEcho = 0x8000;  // XV-11: the range is invalid; Camsense: there is none

std::uint8_t clipped(unsigned strength) { return static_cast<std::uint8_t>(std::min(strength, 255U)); }

std::size_t xv11Size(Bytes head) {
  return head[0] == 0xFA && head[1] >= kFirstIndex && head[1] <= 0xF9 ? kXv11Size : 0;
}
bool xv11Good(Bytes packet) { return checkOf(packet.first(kXv11Size - 2)) == u16At(packet, kXv11Size - 2); }
void xv11Nodes(Bytes packet, std::vector<LidarNode>& out) {
  constexpr unsigned kRange = 0x3FFF, kSamples = 4;
  for (unsigned i = 0; i < kSamples; ++i) {
    const unsigned distance = u16At(packet, 4 + 4 * i);
    out.push_back({.angle_q6 = nodeAngle(64L * (kSamples * (packet[1] - kFirstIndex) + i)),
                   .distance_q2 = (distance & kNoEcho) != 0 ? 0 : 4 * (distance & kRange),
                   .quality = clipped(u16At(packet, 6 + 4 * i))});
  }
}

std::size_t lds01Size(Bytes head) {
  return head[0] == 0xFA && head[1] >= kFirstIndex && head[1] <= 0xDB ? kLds01Size : 0;
}
/// What its last two bytes are is not settled: where they are alike they have to be the sum, else the values decide.
bool lds01Good(Bytes packet) {
  constexpr unsigned kFastest = 6000, kFurthest = 6000;  // [rpm * 10], [mm]
  if (packet[40] == packet[41]) {
    unsigned sum = 0;
    for (const std::uint8_t byte : packet.first(40)) sum += byte;
    return packet[40] == ((0xFF - sum) & 0xFF);
  }
  bool good = u16At(packet, 2) <= kFastest;
  for (std::size_t i = 0; i < 6; ++i) good = good && u16At(packet, 6 + 6 * i) <= kFurthest;
  return good;
}
void lds01Nodes(Bytes packet, std::vector<LidarNode>& out) {
  constexpr unsigned kSamples = 6;
  for (unsigned i = 0; i < kSamples; ++i) {
    out.push_back({.angle_q6 = nodeAngle(64L * (kSamples * (packet[1] - kFirstIndex) + i)),
                   .distance_q2 = 4 * u16At(packet, 6 + 6 * i),
                   .quality = clipped(u16At(packet, 4 + 6 * i))});
  }
}

constexpr unsigned kZeroAngle = 0xA000;  // Camsense

std::size_t camsenseSize(Bytes head) {
  return head[0] == 0x55 && head[1] == 0xAA && head[2] == 0x03 && head[3] == 0x08 ? kCamsenseSize : 0;
}
/// An angle below zero's is that of a motor that has not its speed yet.
bool camsenseGood(Bytes packet) {
  return checkOf(packet.first(kCamsenseSize - 2)) == u16At(packet, kCamsenseSize - 2) &&
         u16At(packet, 6) >= kZeroAngle && u16At(packet, 32) >= kZeroAngle;
}
void camsenseNodes(Bytes packet, std::vector<LidarNode>& out) {
  constexpr std::size_t kSamples = 8;
  constexpr long kTurn = 360 * 64;
  const long first = static_cast<long>(u16At(packet, 6)) - kZeroAngle;
  const long turned = (static_cast<long>(u16At(packet, 32)) - kZeroAngle - first + kTurn) % kTurn;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const unsigned distance = u16At(packet, 8 + 3 * i);
    const double angle =
        static_cast<double>(first) + static_cast<double>(turned) * static_cast<double>(i) / (kSamples - 1.0);
    out.push_back({.angle_q6 = nodeAngle(std::lround(angle)),
                   .distance_q2 = (distance & kNoEcho) != 0 ? 0 : 4 * distance,
                   .quality = packet[10 + 3 * i]});
  }
}

}  // namespace

unsigned checkOf(Bytes bytes) {
  std::uint32_t sum = 0;
  for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) sum = (sum << 1) + u16At(bytes, at);
  return ((sum & 0x7FFF) + (sum >> 15)) & 0x7FFF;
}

const LidarPackets kXv11Packets{2, kXv11Size, xv11Size, xv11Good, xv11Nodes};
const LidarPackets kLds01Packets{2, kLds01Size, lds01Size, lds01Good, lds01Nodes};
const LidarPackets kCamsensePackets{4, kCamsenseSize, camsenseSize, camsenseGood, camsenseNodes};

}  // namespace slam::neato
