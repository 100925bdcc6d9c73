// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <utility>

namespace slam::test {

/// Allocations (operator new) of this thread so far.
std::uint64_t allocationCount();

/// Frees (operator delete) of this thread so far.
std::uint64_t freeCount();

template <typename Body>
std::uint64_t allocationsDuring(Body&& body) {
  const std::uint64_t before = allocationCount();
  std::forward<Body>(body)();
  return allocationCount() - before;
}

}  // namespace slam::test
