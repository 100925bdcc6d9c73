// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "core/timestamp.hpp"

namespace slam {

/// CLOCK_MONOTONIC.
Timestamp monotonicNow();

/// CLOCK_REALTIME minus CLOCK_MONOTONIC at this moment.
Duration wallClockOffset();

/// Maps stamps to `utime` of messages by the offset at construction. A later step of the wall clock does not move it,
/// so that the stamps of a run stay comparable; see drift().
class WallClock {
 public:
  WallClock() : offset_(wallClockOffset()) {}
  std::int64_t utime(Timestamp stamp) const { return toMicroseconds(stamp + offset_); }
  Timestamp stamp(std::int64_t utime) const { return fromMicroseconds(utime) - offset_; }
  /// How far the wall clock has been set since construction.
  Duration drift() const { return wallClockOffset() - offset_; }

 private:
  Duration offset_;
};

}  // namespace slam
