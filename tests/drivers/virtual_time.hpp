// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>

#include "core/timestamp.hpp"

namespace slam::test {

/// Time that passes only when a test says so.
inline Timestamp virtual_now{std::chrono::seconds(1000)};
inline Timestamp virtualNow() { return virtual_now; }

/// Lets it pass by ticks of 211 Hz, with `step` done in each, until the condition holds.
/// @return false when it did not within 30 s
template <typename Step, typename Condition>
[[nodiscard]] bool tickUntil(Step&& step, Condition&& condition) {
  constexpr Duration kTick = std::chrono::nanoseconds(1'000'000'000 / 211);
  for (const Timestamp deadline = virtual_now + std::chrono::seconds(30); !condition();) {
    if (virtual_now > deadline) return false;
    virtual_now += kTick;
    step();
  }
  return true;
}

}  // namespace slam::test
