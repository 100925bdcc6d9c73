// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/link_watch.hpp"

#include <algorithm>
#include <cerrno>

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kKeep = 200ms;     // between two messages whose copies are awaited
constexpr Duration kUnheard = 2s;     // ten of them in a row do not get lost under load
constexpr Duration kNotSent = 500ms;  // without one message that was sent

}  // namespace

bool LinkWatch::isFailing(Timestamp now) const { return failing_since_ && now - *failing_since_ >= kNotSent; }

void LinkWatch::sent(std::string_view channel, std::span<const std::uint8_t> data, Timestamp now) {
  if (isFailing(now)) unheard_since_.reset();  // nothing that could have come back
  failing_since_.reset();
  if (kept_ && now - *kept_ < kKeep) return;
  channel_ = channel;
  data_.assign(data.begin(), data.end());
  awaited_ = true;
  kept_ = now;
  if (!unheard_since_) unheard_since_ = now;
}

void LinkWatch::failed(int error, Timestamp now) {
  failure_ = error == EPERM || error == EACCES ? LinkState::kBlocked : LinkState::kNoRoute;
  if (!failing_since_) failing_since_ = now;
}

void LinkWatch::heard(const Packet& packet) {
  if (!awaited_ || packet.kind != Packet::kMessage || packet.channel != channel_) return;
  if (!std::equal(packet.data.begin(), packet.data.end(), data_.begin(), data_.end())) return;
  awaited_ = false;
  heard_ = true;
  unheard_since_.reset();
}

void LinkWatch::missed() { unheard_since_.reset(); }

LinkState LinkWatch::state(Timestamp now) const {
  if (isFailing(now)) return failure_;
  if (unheard_since_ && now - *unheard_since_ >= kUnheard) return LinkState::kUnheard;
  return heard_ ? LinkState::kConnected : LinkState::kOpening;
}

std::string causeOf(LinkState state, const UdpmUrl& url) {
  const std::string port = "udp " + std::to_string(url.port());
  switch (state) {
    case LinkState::kNoRoute:
      return "no multicast route";
    case LinkState::kBlocked:
      return "not permitted to send; does a firewall or the unit block " + port + "?";
    case LinkState::kUnheard:
      return "sent packets do not come back; is " + port + " blocked?";
    case LinkState::kNoSocket:
      return "no socket for " + port + "; has another program taken it?";
    default:
      return "";
  }
}

std::string fixOf(LinkState state, const UdpmUrl& url) {
  const std::string port = std::to_string(url.port());
  switch (state) {
    case LinkState::kNoRoute:
      return url.ttl == 0
                 ? "ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo"
                 : "connect the network, or ip route add 224.0.0.0/4 dev INTERFACE with the interface that goes "
                   "to the other computers (ip -br addr)";
    case LinkState::kBlocked:
      return "let udp " + port +
             " out (nft list ruleset), and IPAddressAllow=" + url.name().substr(0, url.name().find(':')) +
             " in the unit (systemctl cat slamd)";
    case LinkState::kUnheard:
      return "let udp " + port + " in (nft list ruleset); ip route get " + url.name().substr(0, url.name().find(':')) +
             " names the interface";
    case LinkState::kNoSocket:
      return "ss -ulnp 'sport = :" + port + "' names the program";
    default:
      return "";
  }
}

}  // namespace slam
