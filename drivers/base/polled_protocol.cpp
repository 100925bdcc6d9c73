// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/polled_protocol.hpp"

#include <algorithm>

namespace slam {

void PolledProtocol::begin(Timestamp now) {
  forget();
  pending_.reset();
  synced_ = false;
  next_counts_ = rests_until_ = now;
}

Outgoing PolledProtocol::ask(Request request, const Outgoing& bytes, Timestamp now) {
  pending_ = request;
  requested_ = now;
  return bytes;
}

Outgoing PolledProtocol::question(Timestamp now) {
  if (rests(now)) return {};
  if (pending_) {
    if (now - requested_ < kAnswer) return {};
    pending_.reset();
    forget();
    ++unanswered_;
    synced_ = false;
  }
  if (!synced_) return ask(Request::kSync, encode(Request::kSync), now);
  if (const Outgoing other = encodeOther(now); !other.empty()) return ask(Request::kOther, other, now);
  if (now < next_counts_) return {};
  next_counts_ = std::max(next_counts_ + period_, now);
  return ask(Request::kCounts, encode(Request::kCounts), now);
}

bool PolledProtocol::takesSpeeds(Timestamp now) const { return !rests(now) && (!synced_ || !pending_); }

Outgoing PolledProtocol::speeds(const SideSpeeds& wanted, Timestamp now) {
  const Outgoing bytes = encodeSpeeds(wanted);
  return synced_ ? ask(Request::kSpeeds, bytes, now) : bytes;  // else its answer acknowledges nothing
}

bool PolledProtocol::settle(Request request) {
  if (pending_ != request) return false;
  pending_.reset();
  synced_ = synced_ || request == Request::kSync;
  return true;
}

}  // namespace slam
