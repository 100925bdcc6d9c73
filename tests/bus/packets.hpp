// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace slam::test {

inline void putNumber(std::vector<std::uint8_t>& packet, std::uint32_t value, int bytes) {
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) packet.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// A whole message as liblcm sends it.
inline std::vector<std::uint8_t> packetOf(const std::string& channel, std::span<const std::uint8_t> message,
                                          std::uint32_t sequence = 0) {
  std::vector<std::uint8_t> packet = {'L', 'C', '0', '2'};
  putNumber(packet, sequence, 4);
  packet.insert(packet.end(), channel.begin(), channel.end());
  packet.push_back(0);
  packet.insert(packet.end(), message.begin(), message.end());
  return packet;
}

/// A part of a message that needs several packets; numbered by `number` of `count`, of which the first names the
/// channel.
struct Fragment {
  std::uint32_t size = 0, offset = 0;  ///< [bytes] of the message, and of the part in it
  std::uint32_t number = 0, count = 0;
};
inline std::vector<std::uint8_t> fragmentOf(const Fragment& fragment, const std::string& channel, std::size_t payload) {
  std::vector<std::uint8_t> packet = {'L', 'C', '0', '3'};
  putNumber(packet, 7, 4);  // the sequence
  putNumber(packet, fragment.size, 4);
  putNumber(packet, fragment.offset, 4);
  putNumber(packet, fragment.number, 2);
  putNumber(packet, fragment.count, 2);
  if (fragment.number == 0) {
    packet.insert(packet.end(), channel.begin(), channel.end());
    packet.push_back(0);
  }
  packet.insert(packet.end(), payload, 0x41);
  return packet;
}

/// The fragment that makes Debian's liblcm write before its buffer: offset and size together pass 2^32.
inline std::vector<std::uint8_t> deadlyFragment(const std::string& channel) {
  return fragmentOf({.size = 1000, .offset = 0xFFFFFFF0, .number = 0, .count = 2}, channel, 100);
}

}  // namespace slam::test
