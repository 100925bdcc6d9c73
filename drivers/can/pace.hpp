// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>

#include "core/timestamp.hpp"

namespace slam {

/// At which period frames come, learned: the middle one of the last three steps that were about as long, which neither
/// a lost frame nor two that came at once change, nor a bus that fails again and again: how long it fails is chance.
/// Until there were three, the shortest step.
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
    steps_[count_++ % steps_.size()] = step;
    auto sorted = steps_;
    std::sort(sorted.begin(), sorted.end());
    if (count_ >= steps_.size() && sorted.back() <= sorted.front() + sorted.front() / 2) {
      period_ = std::min(sorted[1], kLongest);
      agreed_ = true;
    } else if (!agreed_) {
      period_ = std::min(count_ == 1 ? kLongest : period_, step);
    }
  }

  Timestamp last_{};
  Duration period_{0};
  std::array<Duration, 3> steps_{};
  std::size_t count_ = 0;
  bool agreed_ = false;
};

/// How long nothing may come of what has a period: one may be lost, and the next be a quarter late.
/// @param least however short the period is, or where it is not known
inline Duration patienceFor(Duration period, Duration least) { return std::max(least, 2 * period + period / 4); }

}  // namespace slam
