// SPDX-License-Identifier: BSD-3-Clause
// What all capsules share.
#include "drivers/lidar/codec/rplidar_capsules.hpp"

namespace slam::rplidar {
namespace {

constexpr std::uint8_t kFirstSync = 0xA0, kSecondSync = 0x50;
constexpr int kTurnQ6 = 360 * 64, kTurnQ16 = 360 * 65536;
constexpr int kStartBit = 0x8000;

std::uint8_t checksum(std::span<const std::uint8_t> bytes) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : bytes.subspan(2)) sum ^= byte;
  return sum;
}

}  // namespace

bool hasCapsuleSync(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 2 && (bytes[0] & 0xF0) == kFirstSync && (bytes[1] & 0xF0) == kSecondSync;
}

std::optional<CapsuleHead> parseCapsuleHead(std::span<const std::uint8_t> bytes, std::size_t angle_at) {
  if (bytes.size() < angle_at + 2 || !hasCapsuleSync(bytes)) return std::nullopt;
  if (((bytes[0] & 0x0F) | (bytes[1] & 0x0F) << 4) != checksum(bytes)) return std::nullopt;
  const int word = bytes[angle_at] | bytes[angle_at + 1] << 8;
  return CapsuleHead{static_cast<std::uint16_t>((word & ~kStartBit) % kTurnQ6), (word & kStartBit) != 0};
}

void sealCapsule(const CapsuleHead& head, std::span<std::uint8_t> bytes, std::size_t angle_at) {
  const int word = head.start_angle_q6 | (head.start ? kStartBit : 0);
  bytes[angle_at] = static_cast<std::uint8_t>(word);
  bytes[angle_at + 1] = static_cast<std::uint8_t>(word >> 8);
  const std::uint8_t sum = checksum(bytes);
  bytes[0] = static_cast<std::uint8_t>(kFirstSync | (sum & 0x0F));
  bytes[1] = static_cast<std::uint8_t>(kSecondSync | sum >> 4);
}

CapsuleSpan::CapsuleSpan(std::uint16_t start_angle_q6, std::uint16_t next_start_angle_q6, int count)
    : start_q6_(start_angle_q6 % kTurnQ6), width_q6_(next_start_angle_q6 % kTurnQ6 - start_q6_), count_(count) {
  if (width_q6_ < 0) width_q6_ += kTurnQ6;
}

RawAngle CapsuleSpan::at(int k) const {
  const auto q16 = [this](int sample) {
    return (start_q6_ << 10) + static_cast<int>((static_cast<std::int64_t>(width_q6_) << 10) * sample / count_);
  };
  const int raw = q16(k);
  return {raw % kTurnQ16, q16(k + 1) / kTurnQ16 > raw / kTurnQ16};
}

}  // namespace slam::rplidar
