// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>

#include "core/timestamp.hpp"

namespace slam {

/// When to try again what failed, such as a device that could not be opened or was lost: soon at first, then less
/// often.
class Retry {
 public:
  /// @param first wait, behind one failure; it doubles with each further one
  explicit Retry(Duration first, Duration longest = std::chrono::seconds(1)) : first_(first), longest_(longest) {}

  bool due(Timestamp now) const { return now >= next_; }
  void failed(Timestamp now) {
    wait_ = std::clamp(2 * wait_, first_, longest_);
    next_ = now + wait_;
  }
  void succeeded() { wait_ = Duration(0); }

 private:
  Duration first_, longest_, wait_{0};
  Timestamp next_{};
};

}  // namespace slam
