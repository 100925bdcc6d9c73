// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/codec/ydlidar_packets.hpp"

#include <cmath>
#include <numbers>

namespace slam::ydlidar {
namespace {

using Bytes = LidarPackets::Bytes;

constexpr std::size_t kFirst = 4, kLast = 6, kCheck = 8;

template <std::size_t Width>
std::size_t size(Bytes head) {
  const bool begins = head[0] == 0xAA && head[1] == 0x55 && head[3] <= kMostSamples && (head[4] & head[6] & 1) == 1;
  return begins ? kHead + Width * head[3] : 0;
}

template <std::size_t Width>
bool good(Bytes packet) {
  constexpr unsigned kTurn = 360 * 64;
  return checkOf(packet, Width) == u16At(packet, kCheck) && u16At(packet, kFirst) >> 1 < kTurn &&
         u16At(packet, kLast) >> 1 < kTurn;
}

enum class Kind { kPlain, kBright, kTimeOfFlight, kCoin };

template <Kind kKind>
void nodes(Bytes packet, std::vector<LidarNode>& out) {
  constexpr std::size_t kWidth = kKind == Kind::kPlain ? 2 : 3;
  constexpr bool kTriangulates = kKind == Kind::kPlain || kKind == Kind::kBright;
  constexpr long kTurn = 360 * 64;
  const std::size_t samples = packet[3];
  const long first = static_cast<long>(u16At(packet, kFirst) >> 1);
  const long turned = (static_cast<long>(u16At(packet, kLast) >> 1) - first + kTurn) % kTurn;
  for (std::size_t i = 0; i < samples; ++i) {
    const std::size_t at = kHead + i * kWidth;
    const unsigned value = u16At(packet, at + kWidth - 2);
    const unsigned distance_q2 = kKind == Kind::kPlain ? value : value & 0xFFFC;  // their low two bits are flags
    double angle = static_cast<double>(first);
    if (samples > 1) angle += static_cast<double>(turned) * static_cast<double>(i) / static_cast<double>(samples - 1);
    if (kTriangulates && distance_q2 > 0) angle += 64.0 * shiftOf(0.25 * distance_q2);
    unsigned quality = 0;
    if constexpr (kKind == Kind::kCoin) quality = (value & 3) << 6 | packet[at] >> 2;
    if constexpr (kKind == Kind::kBright || kKind == Kind::kTimeOfFlight) quality = packet[at];
    out.push_back({.angle_q6 = nodeAngle(std::lround(angle)),
                   .distance_q2 = distance_q2,
                   .quality = static_cast<std::uint8_t>(quality)});
  }
}

template <Kind kKind, std::size_t Width>
constexpr LidarPackets packets() {
  return {kHead, kHead + Width * kMostSamples, size<Width>, good<Width>, nodes<kKind>};
}

}  // namespace

unsigned checkOf(Bytes packet, std::size_t width) {
  unsigned check = u16At(packet, 0) ^ u16At(packet, 2) ^ u16At(packet, kFirst) ^ u16At(packet, kLast);
  for (std::size_t at = kHead; at + width <= packet.size(); at += width) {
    if (width == 3) check ^= packet[at];
    check ^= u16At(packet, at + width - 2);
  }
  return check;
}

double shiftOf(double distance_mm) {
  constexpr double kOffset = 21.8, kZero = 155.3;  // [mm]
  return std::atan(kOffset * (kZero - distance_mm) / (kZero * distance_mm)) * 180.0 / std::numbers::pi;
}

const LidarPackets kPlainPackets = packets<Kind::kPlain, 2>();
const LidarPackets kBrightPackets = packets<Kind::kBright, 3>();
const LidarPackets kTimeOfFlightPackets = packets<Kind::kTimeOfFlight, 3>();
const LidarPackets kCoinPackets = packets<Kind::kCoin, 3>();

}  // namespace slam::ydlidar
