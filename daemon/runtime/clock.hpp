// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>

#include "core/timestamp.hpp"

namespace slam {

/// CLOCK_MONOTONIC.
Timestamp monotonicNow();

/// CLOCK_REALTIME minus CLOCK_MONOTONIC at this moment.
Duration wallClockOffset();

/// Maps stamps to `utime` of messages by the offset at construction. A later step of the wall clock does not move it by
/// itself; see drift() and follow(). From any thread, but for follow(), which is one's.
class WallClock {
 public:
  WallClock() : begun_(wallClockOffset()), offset_(begun_.count()) {}
  std::int64_t utime(Timestamp stamp) const { return toMicroseconds(stamp + offset()); }
  Timestamp stamp(std::int64_t utime) const { return fromMicroseconds(utime) - offset(); }
  /// How far the wall clock has been set since construction, or since it was followed.
  Duration drift() const { return wallClockOffset() - offset(); }
  /// From now on utime goes by the wall clock as it is now. @param drift of before, which is not below zero: a utime
  /// that was given is never given again
  void follow(Duration drift) { offset_.fetch_add(drift.count(), std::memory_order_relaxed); }
  /// How far utime has been moved since construction: recordings go on without the step.
  Duration followed() const { return offset() - begun_; }

 private:
  Duration offset() const { return Duration(offset_.load(std::memory_order_relaxed)); }

  const Duration begun_;
  std::atomic<Duration::rep> offset_;
};

}  // namespace slam
