// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <atomic>
#include <cstdint>

namespace slam {

/// Hands the newest value from one writer to one reader. Neither ever waits (triple buffer): the writer fills the back
/// slot and swaps it with the middle one, the reader swaps the middle one with its front slot.
template <typename T>
class LatestValue {
 public:
  void store(const T& value) {
    slots_[back_] = value;
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }

  /// @return true when `value` was set to something newer than the last call gave
  bool load(T& value) {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    value = slots_[front_];
    return true;
  }

 private:
  static constexpr std::uint8_t kFresh = 4, kIndex = 3;
  std::array<T, 3> slots_{};
  std::uint8_t back_ = 0;                // writer's
  std::atomic<std::uint8_t> middle_{1};  // slot index, and whether it is newer than the front one
  std::uint8_t front_ = 2;               // reader's
};

/// The end that gives ...
template <typename T>
class LatestWriter {
 public:
  LatestWriter(LatestValue<T>& value) : value_(&value) {}
  void store(const T& value) const { value_->store(value); }

 private:
  LatestValue<T>* value_;
};

/// ... and the end that takes.
template <typename T>
class LatestReader {
 public:
  LatestReader(LatestValue<T>& value) : value_(&value) {}
  bool load(T& value) const { return value_->load(value); }

 private:
  LatestValue<T>* value_;
};

}  // namespace slam
