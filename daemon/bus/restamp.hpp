// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace slam {

/// All messages begin with the eight bytes of their type's fingerprint and with utime, the highest byte first.
inline constexpr std::size_t kStampAt = 8, kStampSize = 8;

/// @return [us]; 0 where a message is too short to have one
inline std::int64_t utimeOf(std::span<const std::uint8_t> message) {
  if (message.size() < kStampAt + kStampSize) return 0;
  std::uint64_t utime = 0;
  for (std::size_t i = 0; i < kStampSize; ++i) utime = utime << 8 | message[kStampAt + i];
  return static_cast<std::int64_t>(utime);
}

/// The message with another stamp. @param room for it
inline std::span<const std::uint8_t> restamped(std::span<const std::uint8_t> message, std::int64_t utime,
                                               std::vector<std::uint8_t>& room) {
  room.assign(message.begin(), message.end());
  const auto bits = static_cast<std::uint64_t>(utime);
  for (std::size_t i = 0; i < kStampSize && room.size() >= kStampAt + kStampSize; ++i)
    room[kStampAt + i] = static_cast<std::uint8_t>(bits >> (8 * (kStampSize - 1 - i)));
  return room;
}

}  // namespace slam
