// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/link_watch.hpp"

#include <algorithm>
#include <cerrno>

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kKeep = 200ms;     // between two messages whose copies are awaited
constexpr Duration kNoLoopback = 2s;  // ten of them in a row do not get lost under load
constexpr Duration kNotSent = 500ms;  // without one message that was sent

}  // namespace

bool LinkWatch::isFailing(Timestamp now) const { return failing_since_ && now - *failing_since_ >= kNotSent; }

void LinkWatch::sent(std::string_view channel, std::span<const std::uint8_t> data, Timestamp now) {
  if (isFailing(now)) no_loopback_since_.reset();  // nothing that could have come back
  failing_since_.reset();
  if (kept_ && now - *kept_ < kKeep) return;
  channel_ = channel;
  data_.assign(data.begin(), data.end());
  awaited_ = true;
  kept_ = now;
  if (!no_loopback_since_) no_loopback_since_ = now;
}

void LinkWatch::failed(int error, Timestamp now) {
  failure_ = error == EPERM || error == EACCES ? LinkState::kBlocked : LinkState::kNoRoute;
  if (!failing_since_) failing_since_ = now;
}

void LinkWatch::received(const Packet& packet) {
  if (!awaited_ || packet.kind != Packet::kMessage || packet.channel != channel_) return;
  if (!std::equal(packet.data.begin(), packet.data.end(), data_.begin(), data_.end())) return;
  awaited_ = false;
  ever_received_ = true;
  no_loopback_since_.reset();
}

void LinkWatch::missed() { no_loopback_since_.reset(); }

LinkState LinkWatch::state(Timestamp now) const {
  if (isFailing(now)) return failure_;
  if (no_loopback_since_ && now - *no_loopback_since_ >= kNoLoopback) return LinkState::kNoLoopback;
  return ever_received_ ? LinkState::kConnected : LinkState::kOpening;
}

Problem problemOf(LinkState state, const UdpmUrl& url) {
  const std::string port = std::to_string(url.port()), name = url.name();
  const auto of = [&](const ProblemKind& kind) { return Problem(kind, {}, {port, name.substr(0, name.find(':'))}); };
  switch (state) {
    case LinkState::kNoRoute:
      return of(url.ttl == 0 ? problem::kNoLocalRoute : problem::kNoRoute);
    case LinkState::kBlocked:
      return of(problem::kLinkBlocked);
    case LinkState::kNoLoopback:
      return of(problem::kLinkUnheard);
    case LinkState::kNoSocket:
      return of(problem::kNoLcmSocket);
    default:
      return {};
  }
}

}  // namespace slam
