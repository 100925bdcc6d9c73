// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>

#include "core/timestamp.hpp"

namespace slam {

/// When to try a device again that could not be opened or was lost: soon at first, then less often.
class Retry {
 public:
  /// @param first wait, behind one failure; it doubles with each further one, up to a second
  explicit Retry(Duration first) : first_(first) {}

  bool due(Timestamp now) const { return now >= next_; }
  void failed(Timestamp now) {
    wait_ = std::clamp(2 * wait_, first_, kLongest);
    next_ = now + wait_;
  }
  void succeeded() { wait_ = Duration(0); }

 private:
  static constexpr Duration kLongest = std::chrono::seconds(1);
  Duration first_, wait_{0};
  Timestamp next_{};
};

}  // namespace slam
