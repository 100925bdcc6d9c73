// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/lidar/lidar_decoder.hpp"

namespace slam {

/// The packets of a lidar that sends them one behind the other, each with a checksum. Pure functions over bytes.
struct LidarPackets {
  using Bytes = std::span<const std::uint8_t>;

  std::size_t head = 0;                                     ///< [bytes] that size() needs
  std::size_t longest = 0;                                  ///< [bytes]
  std::size_t (*size)(Bytes head) = nullptr;                ///< [bytes] of the packet that begins so; 0: none does
  bool (*good)(Bytes packet) = nullptr;                     ///< its checksum fits and its values can be
  void (*nodes)(Bytes, std::vector<LidarNode>&) = nullptr;  ///< appends them in order; `start` stays unset
};

inline unsigned u16At(LidarPackets::Bytes bytes, std::size_t at) {
  return bytes[at] | static_cast<unsigned>(bytes[at + 1]) << 8;
}

/// An angle [deg * 64] of any turn, as a node has it.
inline std::uint16_t nodeAngle(long angle_q6) {
  constexpr long kTurn = 360L * 64;
  return static_cast<std::uint16_t>((angle_q6 % kTurn + kTurn) % kTurn);
}

}  // namespace slam
