// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace slam {

/// One UDP packet as LCM's udpm provider sends them: "LC02", a sequence number, the channel's name with its zero, the
/// message. A message that does not fit one packet goes in fragments ("LC03"), which parseFragment() reads.
struct Packet {
  enum Kind : std::uint8_t { kMessage, kFragment, kOther } kind = kOther;
  std::string_view channel;            ///< of a message, and of a message's first fragment; else empty
  std::span<const std::uint8_t> data;  ///< of a message
};

/// @param datagram the whole of it; the result points into it
/// @return kOther for what is no packet of LCM, or names no channel of at most 63 characters
Packet parsePacket(std::span<const std::uint8_t> datagram);

/// One part of a message that does not fit one packet, as it claims to be: no number in it is checked.
struct Fragment {
  std::uint32_t sequence = 0, size = 0, offset = 0;  ///< of the message, its bytes, and of the part in it
  std::uint16_t number = 0, count = 0;               ///< of the part, counting from 0, and of all
  std::string_view channel;                          ///< of the first part; else empty
  std::span<const std::uint8_t> data;
};
/// @param datagram one that parsePacket() knows as Packet::kFragment; the result points into it
Fragment parseFragment(std::span<const std::uint8_t> datagram);

/// A whole message as one packet, in place of what was in `packet`.
void writePacket(std::string_view channel, std::span<const std::uint8_t> data, std::vector<std::uint8_t>& packet);

}  // namespace slam
