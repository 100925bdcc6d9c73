// SPDX-License-Identifier: BSD-3-Clause
#include "timing/refresh_clock.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr int kEnough = 24;          // changes that agree with a period, one after the other
constexpr double kTooSeldom = 0.85;  // [1] of the period: two renewals may hide between such requests
constexpr int kBroken = 4;           // contradictions in a row
constexpr Duration kForgotten = std::chrono::seconds(60);  // without a change; the period is known to some 1e-5

std::int64_t nanoseconds(Timestamp stamp) { return stamp.time_since_epoch().count(); }

}  // namespace

void RefreshClock::restart() {
  locked_.reset();
  for (Candidate& candidate : candidates_) candidate.changes = 0;
}

std::optional<Timestamp> RefreshClock::stamp(const Change& change) {
  if (locked_ && change.asked - locked_->last > kForgotten) restart();
  if (!locked_) {
    learn(change);
    return std::nullopt;
  }
  const Timestamp taken = follow(*locked_, change);
  if (locked_->contradictions >= kBroken) restart();
  return taken;
}

void RefreshClock::learn(const Change& change) {
  for (Candidate& candidate : candidates_) {
    if (change.asked - change.old_asked > kTooSeldom * candidate.period) {
      candidate.changes = 0;
      continue;
    }
    candidate.earliest = std::max(candidate.earliest + candidate.period, change.old_asked);
    candidate.latest = std::min(candidate.latest + candidate.period, change.answered);
    if (candidate.changes == 0 || candidate.earliest > candidate.latest) {
      candidate.earliest = change.old_asked;
      candidate.latest = change.answered;
      candidate.changes = 0;
    }
    if (++candidate.changes < kEnough) continue;
    const auto period = static_cast<double>(candidate.period.count());
    locked_ = Lock{LowerEnvelope(-period), LowerEnvelope(period), 0, change.asked};
    // The first point of each line is what all changes so far agree on.
    locked_->before.add(0, -nanoseconds(candidate.earliest));
    locked_->after.add(0, nanoseconds(candidate.latest));
    locked_->last = candidate.earliest + (candidate.latest - candidate.earliest) / 2;
    return;
  }
}

Timestamp RefreshClock::follow(Lock& lock, const Change& change) {
  const double period = lock.after.period();  // [ns]
  const auto middleOf = [&](std::int64_t index) {
    const std::int64_t earliest = -lock.before.at(index), latest = lock.after.at(index);
    return Timestamp(Duration(latest > earliest ? earliest + (latest - earliest) / 2 : earliest));
  };
  const auto renewalsUntil = [&, last = middleOf(lock.index)](Timestamp t) {
    return static_cast<double>((t - last).count()) / period;
  };
  std::int64_t index = lock.index + 1;
  if (static_cast<double>((change.asked - change.old_asked).count()) > kTooSeldom * period) {
    index = std::max<std::int64_t>(index, lock.index + static_cast<std::int64_t>(renewalsUntil(change.asked)));
  } else {
    const Timestamp middle = change.old_asked + (change.asked - change.old_asked) / 2;
    index = std::max<std::int64_t>(index, lock.index + std::llround(renewalsUntil(middle)));
    lock.before.add(index, -nanoseconds(change.old_asked));
    lock.after.add(index, nanoseconds(change.asked));
  }
  const Timestamp taken = middleOf(index);
  lock.contradictions = taken > change.answered ? lock.contradictions + 1 : 0;
  lock.index = index;
  lock.last = std::clamp(taken, change.old_asked, change.answered);
  return lock.last;
}

}  // namespace slam
