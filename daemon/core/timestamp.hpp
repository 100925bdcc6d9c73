// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <cstdint>

namespace slam {

/// The clock all stamps inside slamd belong to: CLOCK_MONOTONIC in the daemon, the log's own time in a replay.
/// It has no now() on purpose: code that works on stamps cannot read the clock, and so behaves the same on a log.
struct MonotonicClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = std::chrono::nanoseconds;
  using time_point = std::chrono::time_point<MonotonicClock>;
  static constexpr bool is_steady = true;
};

using Duration = MonotonicClock::duration;
using Timestamp = MonotonicClock::time_point;

constexpr double toSeconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }

/// @param seconds [s], rounded to the nearest nanosecond; |seconds| < 9.2e9
constexpr Duration fromSeconds(double seconds) {
  const double nanoseconds = seconds * 1e9;
  return Duration(static_cast<Duration::rep>(nanoseconds < 0 ? nanoseconds - 0.5 : nanoseconds + 0.5));
}

/// `utime` of a message [µs] to a stamp of the same epoch.
constexpr Timestamp fromMicroseconds(std::int64_t utime) { return Timestamp(std::chrono::microseconds(utime)); }

/// Stamp to microseconds of the same epoch, rounded down.
constexpr std::int64_t toMicroseconds(Timestamp stamp) {
  return std::chrono::floor<std::chrono::microseconds>(stamp.time_since_epoch()).count();
}

/// Reads a clock for statistics only; given from outside, because pure code cannot read one. nullptr: nothing is timed.
using Stopwatch = Timestamp (*)();

}  // namespace slam
