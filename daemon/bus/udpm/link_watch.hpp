// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bus/udpm/lc02.hpp"
#include "bus/udpm/udpm_url.hpp"
#include "core/timestamp.hpp"
#include "problems/daemon.hpp"

namespace slam {

enum class LinkState : std::uint8_t {
  kOpening,     ///< nothing is known yet
  kConnected,   ///< what is sent comes back
  kNoRoute,     ///< the kernel has no way to the group
  kBlocked,     ///< the kernel may not send: a firewall, or the unit's IPAddressDeny
  kNoLoopback,  ///< it sends, but nothing comes back
  kNoSocket     ///< none can be opened
};

/// Whether a state is one that a person has to do something about.
constexpr bool isFault(LinkState state) { return state != LinkState::kOpening && state != LinkState::kConnected; }
/// None where nothing is wrong.
Problem problemOf(LinkState state, const UdpmUrl& url);

/// Assesses a link by what is sent and what comes back: a group's packets return to their sender's machine. Each 200 ms
/// a message is kept, for its copy to be known among those of other programs: their bytes differ by the stamps.
class LinkWatch {
 public:
  void sent(std::string_view channel, std::span<const std::uint8_t> data, Timestamp now);
  void failed(int error, Timestamp now);  ///< @param error errno of the attempt to send
  void received(const Packet& packet);
  /// Packets were dropped here for want of room, or wait still: those that are awaited may be among them.
  void missed();

  LinkState state(Timestamp now) const;

 private:
  bool isFailing(Timestamp now) const;

  std::string channel_;             // of the message that was kept ...
  std::vector<std::uint8_t> data_;  // ... and its bytes
  bool awaited_ = false;            // its copy is
  bool ever_received_ = false;      // one was, ever
  std::optional<Timestamp> kept_;   // when the last one was
  std::optional<Timestamp> no_loopback_since_, failing_since_;
  LinkState failure_ = LinkState::kNoRoute;  // the last one's kind
};

}  // namespace slam
