// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <mutex>
#include <string>
#include <utility>

namespace slam {

/// Words that one thread writes and others read; not for real-time threads.
class SharedText {
 public:
  void set(std::string text) {
    const std::scoped_lock lock(mutex_);
    text_ = std::move(text);
  }
  std::string get() const {
    const std::scoped_lock lock(mutex_);
    return text_;
  }

 private:
  mutable std::mutex mutex_;
  std::string text_;
};

}  // namespace slam
