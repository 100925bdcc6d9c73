// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <thread>

namespace slam::test {

/// Waits for what other threads do. @return false when it has not come by the limit
template <typename Condition>
[[nodiscard]] bool waitUntil(Condition&& condition, std::chrono::nanoseconds limit = std::chrono::seconds(20)) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace slam::test
