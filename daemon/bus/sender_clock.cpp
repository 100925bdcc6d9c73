// SPDX-License-Identifier: BSD-3-Clause
#include "bus/sender_clock.hpp"

#include <algorithm>
#include <utility>

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kPart = 2s;          // of the window: one to two of them are looked at
constexpr Duration kAlike = 500ms;      // ages of one clock, as networks and programs let them differ
constexpr Duration kFar = 1s;           // from the least age: it does not fit
constexpr Duration kUseless = 5s;       // behind the least one: no filter has a use for it
constexpr Duration kSetAfter = 1s;      // a clock was set back when messages are late for so long: a burst is shorter
constexpr Duration kAhead = 20ms;       // of our clock, and ...
constexpr Duration kSlow = 500ms;       // ... behind it: by more, two clocks differ
constexpr Duration kSlowAgain = 300ms;  // less, they do not any more
constexpr Duration kForgotten = 10s;    // of silence of another stream

bool isOneClock(Duration least) { return least >= -kAhead && least <= kSlow; }

}  // namespace

void LeastDelay::begin(Duration age, Timestamp now) {
  present_ = age;
  before_.reset();
  doubted_.reset();
  part_began_ = now;
}

/// Whether messages that do not fit have come for so long, all alike.
bool LeastDelay::confirms(Duration age, Timestamp now, Duration after) {
  const bool follows = doubted_ && std::chrono::abs(age - *doubted_) < kAlike && now - doubted_last_ < kPart;
  doubted_last_ = now;
  doubted_ = age;
  if (!follows) doubted_since_ = now;
  return follows && now - doubted_since_ >= after;
}

std::optional<Duration> LeastDelay::least() const {
  if (!present_ || !before_) return present_ ? present_ : before_;
  return std::min(*present_, *before_);
}

Refusal LeastDelay::add(Duration age, Timestamp now) {
  last_received_ = now;
  const auto known = least();
  if (!known) {
    if (!isOneClock(age) && !confirms(age, now, confirmed_after_))
      return age < Duration(0) ? Refusal::kAhead : Refusal::kOld;
    begin(age, now);
    return Refusal::kNone;
  }
  if (age < *known - kFar) {
    if (!confirms(age, now, confirmed_after_)) return Refusal::kAhead;
    begin(age, now);
  } else if (age > *known + kFar) {
    if (confirms(age, now, std::max(kSetAfter, confirmed_after_))) {
      begin(age, now);
    } else if (age > *known + kUseless) {
      return Refusal::kOld;
    }
    return Refusal::kNone;
  }
  doubted_.reset();
  if (now - part_began_ >= kPart) {
    before_ = std::exchange(present_, std::nullopt);
    part_began_ = now;
  }
  present_ = present_ ? std::min(*present_, age) : age;
  return Refusal::kNone;
}

std::array<LeastDelay, SenderClocks::kStreams> SenderClocks::fresh() {
  const LeastDelay sensor(Duration(0));
  // A speed that waited on its way must not be taken for one of another clock.
  return {sensor, sensor, sensor, sensor, LeastDelay(1s)};
}

void SenderClocks::begin(Duration ahead) {
  ahead_ = ahead;
  streams_ = fresh();
  differs_ = {};
}

SenderClocks::Mapped SenderClocks::map(Stream stream, Timestamp stamp, Duration lasted, Timestamp now) {
  LeastDelay& own = streams_[stream];
  const Duration age = now - stamp, by_wall = age - ahead_;
  Mapped mapped{.refusal = own.add(age - lasted, now),
                .age = std::chrono::abs(age) < std::chrono::abs(by_wall) ? age : by_wall};
  if (mapped.refusal != Refusal::kNone) return mapped;
  Duration least = *own.least();
  for (const LeastDelay& other : streams_) {
    const auto its = other.least();
    if (its && now - other.lastReceived() < kForgotten && std::chrono::abs(*its - *own.least()) < kAlike)
      least = std::min(least, *its);
  }
  bool& differs = differs_[stream];
  differs = differs ? least < Duration(0) || least > kSlowAgain : !isOneClock(least);
  if (differs) mapped.shift = least;
  mapped.differs = differs && !isOneClock(least - ahead_);
  return mapped;
}

}  // namespace slam
