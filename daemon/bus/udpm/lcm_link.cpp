// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/lcm_link.hpp"

#include <algorithm>
#include <cerrno>

namespace slam {
namespace {

using namespace std::chrono_literals;
using Joined = MulticastReceiver::Joined;
constexpr Duration kLongestPatience = 8s;
constexpr int kMostPackets = 64;

}  // namespace

void LcmLink::tend(Timestamp now) {
  if (now < next_look_) return;
  next_look_ = now + kLook;
  sender_.collect();
  if (state(now) == LinkState::kConnected) patience_ = kLook;
  // The kernel may have forgotten a membership whose interface went and came again under the same number.
  if (state(now) == LinkState::kNoLoopback && now >= next_try_) receiver_.close();
  const Joined joined = receiver_.join();
  interface_ = route_.interface();
  if (joined != Joined::kAsBefore && lcm_) {  // its socket is a member of the group, too, on the interface before
    lcm_.reset();
    sender_.close();
  }
  if (lcm_) return;
  if (joined == Joined::kNoSocket) {
    closed_ = LinkState::kNoSocket;
  } else if (joined == Joined::kNoRoute || !interface_) {  // liblcm would print a page, and lose a descriptor for ever
    closed_ = LinkState::kNoRoute;
  } else if (joined == Joined::kAnew || now >= next_try_) {
    open(now);
  }
}

void LcmLink::open(Timestamp now) {
  next_try_ = now + patience_;
  patience_ = std::min(2 * patience_, kLongestPatience);
  lcm_ = std::make_unique<lcm::LCM>(url_.text);
  if (!lcm_->good()) {
    lcm_.reset();
    closed_ = LinkState::kNoSocket;
    return;
  }
  sender_.open(*interface_);
}

void LcmLink::receive() {
  const auto dropped = receiver_.dropped();
  bool is_drained = false;
  for (int i = 0; i < kMostPackets && !is_drained; ++i) {
    const auto datagram = receiver_.next();
    if (datagram) watch_.received(dispatcher_.take(*datagram));
    is_drained = !datagram;
  }
  // Who gets too little of the CPU to read all has no reason to doubt the network.
  if (!is_drained || receiver_.dropped() != dropped) watch_.missed();
}

bool LcmLink::publish(const std::string& channel, std::span<const std::uint8_t> data, Timestamp now) {
  if (url_.ttl == 0 && route_.interface() != interface_) {
    next_look_ = now;
    tend(now);
  }
  if (!lcm_) return false;
  errno = 0;
  const bool sent = lcm_->publish(channel, data.data(), static_cast<unsigned>(data.size())) == 0;
  published(channel, data, {sent, errno}, now);
  return sent;
}

void LcmLink::published(const std::string& channel, std::span<const std::uint8_t> data,
                        const LcmSender::Outcome& outcome, Timestamp when) {
  if (outcome.sent) watch_.sent(channel, data, when);
  if (!outcome.sent && outcome.error != 0) watch_.failed(outcome.error, when);
}

}  // namespace slam
