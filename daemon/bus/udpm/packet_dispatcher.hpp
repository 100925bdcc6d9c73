// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>

#include "bus/udpm/fragment_assembler.hpp"
#include "bus/udpm/lc02.hpp"

namespace slam {

/// Hands the messages in packets to who subscribed to their channels, and counts all others. A message that came in
/// several packets is put together where its channel may have such, as that of a lidar with thousands of beams; no
/// other is larger than a packet, and its fragments are dropped one by one.
class PacketDispatcher {
 public:
  using Handler = std::function<void(std::span<const std::uint8_t> message)>;
  struct Counts {
    std::uint64_t messages = 0, fragments = 0, others = 0;
  };

  /// One handler a channel.
  void subscribe(const std::string& channel, Handler handler, bool may_be_large = false) {
    handlers_[channel] = {std::move(handler), may_be_large};
  }
  Packet take(std::span<const std::uint8_t> datagram);

  const Counts& counts() const { return counts_; }
  /// A channel that was subscribed to, and whose message is larger than it may be; empty: none so far.
  const std::string& tooLarge() const { return too_large_; }

 private:
  struct Subscription {
    Handler handler;
    bool may_be_large;
  };
  void takeFragment(const Fragment& fragment);

  std::map<std::string, Subscription, std::less<>> handlers_;
  FragmentAssembler fragments_;
  Counts counts_;
  std::string too_large_;
};

}  // namespace slam
