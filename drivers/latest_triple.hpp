// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace slam {

/// Three numbers and a time from one writing thread to one reading thread. Neither ever waits: who reads while they are
/// being written keeps what was there before (a sequence lock that does not retry).
class LatestTriple {
 public:
  struct Value {
    std::array<double, 3> numbers{};
    std::int64_t time = 0;  ///< [ns]; 0: never written
  };

  void store(const Value& value) {
    const std::uint32_t sequence = sequence_.load(std::memory_order_relaxed);
    sequence_.store(sequence + 1, std::memory_order_relaxed);
    for (std::size_t i = 0; i < 3; ++i) numbers_[i].store(value.numbers[i], std::memory_order_release);
    time_.store(value.time, std::memory_order_release);
    sequence_.store(sequence + 2, std::memory_order_release);
  }
  /// The newest value, or the one loaded last when it is being written just now.
  const Value& load() {
    const std::uint32_t before = sequence_.load(std::memory_order_acquire);
    Value value;
    for (std::size_t i = 0; i < 3; ++i) value.numbers[i] = numbers_[i].load(std::memory_order_acquire);
    value.time = time_.load(std::memory_order_acquire);
    if (before % 2 == 0 && sequence_.load(std::memory_order_relaxed) == before) loaded_ = value;
    return loaded_;
  }

 protected:                                 // for a test, of a value that is half written
  std::atomic<std::uint32_t> sequence_{0};  // odd: being written
  std::array<std::atomic<double>, 3> numbers_{};
  std::atomic<std::int64_t> time_{0};

 private:
  Value loaded_;  // of the reader
};

}  // namespace slam
