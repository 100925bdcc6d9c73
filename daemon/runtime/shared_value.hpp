// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <mutex>
#include <utility>

namespace slam {

/// A value that some threads write and others read; not for real-time threads.
template <typename Value>
class SharedValue {
 public:
  void set(Value value) {
    const std::scoped_lock lock(mutex_);
    value_ = std::move(value);
  }
  Value get() const {
    const std::scoped_lock lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  Value value_;
};

}  // namespace slam
