// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>

#include "bus/lc02.hpp"

namespace slam {

/// Hands the messages in packets to who subscribed to their channels, and counts all others. Nobody here needs a
/// message larger than a packet: fragments are dropped one by one.
class PacketDispatcher {
 public:
  using Handler = std::function<void(std::span<const std::uint8_t> message)>;
  struct Counts {
    std::uint64_t messages = 0, fragments = 0, others = 0;
  };

  /// One handler a channel.
  void subscribe(const std::string& channel, Handler handler) { handlers_[channel] = std::move(handler); }
  Packet take(std::span<const std::uint8_t> datagram);

  const Counts& counts() const { return counts_; }
  /// A channel that was subscribed to, and whose message came in fragments; empty: none so far.
  const std::string& tooLarge() const { return too_large_; }

 private:
  std::map<std::string, Handler, std::less<>> handlers_;
  Counts counts_;
  std::string too_large_;
};

}  // namespace slam
