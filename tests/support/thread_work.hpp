// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace slam::test {

/// What one thread did while it had real-time scheduling.
struct ThreadWork {
  std::atomic<std::int32_t> thread{0};  ///< its number in the kernel
  std::atomic<std::uint64_t> allocations{0}, frees{0}, opens{0};
  std::atomic<std::uint64_t> waits{0};  ///< mutexes that another thread held
};

/// In a file that the program under test and the test both map.
struct WorkTable {
  std::atomic<std::size_t> used{0};
  std::array<ThreadWork, 64> threads;
};

}  // namespace slam::test
