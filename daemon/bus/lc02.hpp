// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace slam {

/// One UDP packet as LCM's udpm provider sends them: "LC02", a sequence number, the channel's name with its zero, the
/// message. A message that does not fit one packet goes in fragments ("LC03"), which are not put together here.
struct Packet {
  enum Kind : std::uint8_t { kMessage, kFragment, kOther } kind = kOther;
  std::string_view channel;            ///< of a message, and of a message's first fragment; else empty
  std::span<const std::uint8_t> data;  ///< of a message
};

/// @param datagram the whole of it; the result points into it
/// @return kOther for what is no packet of LCM, or names no channel of at most 63 characters
Packet parsePacket(std::span<const std::uint8_t> datagram);

/// A whole message as one packet, in place of what was in `packet`.
void writePacket(std::string_view channel, std::span<const std::uint8_t> data, std::vector<std::uint8_t>& packet);

}  // namespace slam
