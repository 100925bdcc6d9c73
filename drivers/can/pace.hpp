// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>

#include "core/timestamp.hpp"

namespace slam {

/// At which period frames come, learned: the middle one of the last three steps, which neither a lost frame nor two
/// that came at once change.
class Pace {
 public:
  void add(Timestamp stamp) {
    if (last_ != Timestamp{}) learn(stamp - last_);
    last_ = stamp;
  }
  Duration period() const { return period_; }  ///< 0: not known yet

 private:
  static constexpr Duration kLongest = std::chrono::seconds(2);  // what comes more seldom has none

  void learn(Duration step) {
    steps_[count_ % steps_.size()] = step;
    const std::size_t known = std::min(++count_, steps_.size());
    auto sorted = steps_;
    std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(known));
    period_ = std::min(sorted[(known - 1) / 2], kLongest);
  }

  Timestamp last_{};
  Duration period_{0};
  std::array<Duration, 3> steps_{};
  std::size_t count_ = 0;
};

}  // namespace slam
