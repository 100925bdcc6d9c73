// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/lc02.hpp"

#include <algorithm>
#include <optional>

namespace slam {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kMagic = 4, kShortHead = 8, kLongHead = 20, kLongestName = 63;  // [bytes]
constexpr std::size_t kFragmentNumber = 16;                                           // its place in the long head

std::string_view textOf(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

/// The name at the front of the bytes, without its zero.
std::optional<std::string_view> nameAt(Bytes bytes) {
  const std::string_view text = textOf(bytes.first(std::min(bytes.size(), kLongestName + 1)));
  const auto end = text.find('\0');
  return end == std::string_view::npos ? std::nullopt : std::optional(text.substr(0, end));
}

Packet messageOf(Bytes datagram) {
  const auto channel = nameAt(datagram.subspan(kShortHead));
  if (!channel) return {};
  return {Packet::kMessage, *channel, datagram.subspan(kShortHead + channel->size() + 1)};
}

std::uint32_t numberAt(Bytes bytes, std::size_t at, std::size_t size) {
  std::uint32_t number = 0;
  for (const std::uint8_t byte : bytes.subspan(at, size)) number = number << 8 | byte;
  return number;
}

Packet fragmentOf(Bytes datagram) {
  const bool first = datagram[kFragmentNumber] == 0 && datagram[kFragmentNumber + 1] == 0;
  const auto channel = first ? nameAt(datagram.subspan(kLongHead)) : std::string_view();
  return channel ? Packet{Packet::kFragment, *channel, {}} : Packet{};
}

}  // namespace

Packet parsePacket(Bytes datagram) {
  const std::string_view magic = textOf(datagram.first(std::min(datagram.size(), kMagic)));
  if (magic == "LC02" && datagram.size() > kShortHead) return messageOf(datagram);
  if (magic == "LC03" && datagram.size() >= kLongHead) return fragmentOf(datagram);
  return {};
}

Fragment parseFragment(Bytes datagram) {
  Fragment fragment{.sequence = numberAt(datagram, 4, 4),
                    .size = numberAt(datagram, 8, 4),
                    .offset = numberAt(datagram, 12, 4),
                    .number = static_cast<std::uint16_t>(numberAt(datagram, kFragmentNumber, 2)),
                    .count = static_cast<std::uint16_t>(numberAt(datagram, kFragmentNumber + 2, 2)),
                    .channel = {},
                    .data = datagram.subspan(kLongHead)};
  if (fragment.number == 0) {
    fragment.channel = nameAt(fragment.data).value_or("");
    fragment.data = fragment.data.subspan(fragment.channel.size() + 1);
  }
  return fragment;
}

void writePacket(std::string_view channel, Bytes data, std::vector<std::uint8_t>& packet) {
  constexpr std::string_view kHead("LC02\0\0\0\0", kShortHead);  // the sequence number is for who counts losses
  packet.assign(kHead.begin(), kHead.end());
  packet.insert(packet.end(), channel.begin(), channel.end());
  packet.push_back(0);
  packet.insert(packet.end(), data.begin(), data.end());
}

}  // namespace slam
