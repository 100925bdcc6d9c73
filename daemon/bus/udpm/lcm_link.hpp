// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <span>
#include <string>

#include "bus/udpm/lcm_sender.hpp"
#include "bus/udpm/link_watch.hpp"
#include "bus/udpm/multicast_receiver.hpp"
#include "bus/udpm/multicast_route.hpp"
#include "bus/udpm/packet_dispatcher.hpp"
#include "bus/udpm/udpm_url.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// LCM over UDP multicast: sends through liblcm, receives by itself, and follows the route when it moves to another
/// network interface. No call waits, whatever the network does. It sends only while it is a member of the group where
/// the route goes: elsewhere the kernel does not look at a TTL of 0, and packets would leave the machine.
class LcmLink {
 public:
  /// @throws std::invalid_argument for a URL that parseUdpmUrl() refuses
  explicit LcmLink(const std::string& url) : url_(parseUdpmUrl(url)) {}

  void subscribe(const std::string& channel, PacketDispatcher::Handler handler, bool may_be_large = false) {
    dispatcher_.subscribe(channel, std::move(handler), may_be_large);
  }
  /// Opens what is closed and follows the route. Belongs into each turn of a loop, behind receive(), which may change
  /// what it judges by; does nothing in most.
  void tend(Timestamp now);
  /// To wait for; -1 while closed.
  int descriptor() const { return receiver_.descriptor(); }
  /// Hands out what has arrived, but no more than a queue's worth: sending must have its turn under any load.
  void receive();
  /// Who sent the message that a handler is given, as of MulticastReceiver.
  std::uint64_t senderOfMessage() const { return receiver_.sender(); }
  bool publish(const std::string& channel, std::span<const std::uint8_t> data, Timestamp now);
  /// For another thread, which sends on its own: opened, moved and closed with this link. What it has sent is to be
  /// reported, before receive(), or else its copy is not known when it comes back.
  LcmSender& sender() { return sender_; }
  void published(const std::string& channel, std::span<const std::uint8_t> data, const LcmSender::Outcome& outcome,
                 Timestamp when);

  const UdpmUrl& url() const { return url_; }
  LinkState state(Timestamp now) const { return lcm_ ? watch_.state(now) : closed_; }
  const PacketDispatcher& received() const { return dispatcher_; }
  std::uint64_t dropped() const { return receiver_.dropped(); }

 private:
  void open(Timestamp now);

  const UdpmUrl url_;
  LcmSender sender_{url_};
  std::unique_ptr<lcm::LCM> lcm_;  // only sends: it has no thread, and nobody waits for it
  MulticastReceiver receiver_{url_};
  MulticastRoute route_{url_};
  std::optional<int> interface_;  // of the route when it was followed last
  PacketDispatcher dispatcher_;
  LinkWatch watch_;
  LinkState closed_ = LinkState::kOpening;  // why there is no lcm_
  Timestamp next_look_{}, next_try_{};
  Duration patience_ = kLook;  // between two tries
  static constexpr Duration kLook = std::chrono::seconds(1);
};

}  // namespace slam
