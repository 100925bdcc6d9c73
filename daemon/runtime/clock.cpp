// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/clock.hpp"

#include <ctime>

namespace slam {
namespace {

Duration timeOf(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return std::chrono::seconds(t.tv_sec) + std::chrono::nanoseconds(t.tv_nsec);
}

}  // namespace

Timestamp monotonicNow() { return Timestamp(timeOf(CLOCK_MONOTONIC)); }

Duration wallClockOffset() {
  const Duration before = timeOf(CLOCK_MONOTONIC), wall = timeOf(CLOCK_REALTIME), after = timeOf(CLOCK_MONOTONIC);
  return wall - (before + (after - before) / 2);
}

}  // namespace slam
