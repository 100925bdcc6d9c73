// SPDX-License-Identifier: BSD-3-Clause
#include "bus/packet_dispatcher.hpp"

namespace slam {

Packet PacketDispatcher::take(std::span<const std::uint8_t> datagram) {
  const Packet packet = parsePacket(datagram);
  const auto subscribed = handlers_.find(packet.channel);
  switch (packet.kind) {
    case Packet::kMessage:
      ++counts_.messages;
      if (subscribed != handlers_.end()) subscribed->second(packet.data);
      break;
    case Packet::kFragment:
      ++counts_.fragments;
      if (subscribed != handlers_.end() && too_large_.empty()) too_large_ = packet.channel;
      break;
    case Packet::kOther:
      ++counts_.others;
  }
  return packet;
}

}  // namespace slam
