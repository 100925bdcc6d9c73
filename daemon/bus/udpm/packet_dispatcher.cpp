// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/packet_dispatcher.hpp"

namespace slam {

Packet PacketDispatcher::take(std::span<const std::uint8_t> datagram) {
  const Packet packet = parsePacket(datagram);
  const auto subscribed = handlers_.find(packet.channel);
  switch (packet.kind) {
    case Packet::kMessage:
      ++counts_.messages;
      if (subscribed != handlers_.end()) subscribed->second.handler(packet.data);
      break;
    case Packet::kFragment:
      ++counts_.fragments;
      takeFragment(parseFragment(datagram));
      break;
    case Packet::kOther:
      ++counts_.others;
  }
  return packet;
}

void PacketDispatcher::takeFragment(const Fragment& fragment) {
  const auto mayBeLarge = [this](std::string_view channel) {
    const auto at = handlers_.find(channel);
    return at != handlers_.end() && at->second.may_be_large;
  };
  const bool dropped = fragment.number == 0 && handlers_.contains(fragment.channel) &&
                       (fragment.size > FragmentAssembler::kLargest || !mayBeLarge(fragment.channel));
  if (dropped && too_large_.empty()) too_large_ = fragment.channel;
  if (const auto whole = fragments_.take(fragment, mayBeLarge)) {
    ++counts_.messages;
    handlers_.find(whole->channel)->second.handler(whole->data);
  }
}

}  // namespace slam
