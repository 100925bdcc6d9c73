// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <optional>

#include "core/timestamp.hpp"

namespace slam {

/// Stamps for samples that a device takes at a steady rate but that arrive late by a varying delay. The least delayed
/// arrivals are the best witnesses: a sample is stamped no later than one period (and a little drift) after its
/// predecessor, and no later than it arrived. Stamps never go back.
/// [Olson 2010] E. Olson, "A passive solution to the sensor synchronization problem", Proc. IROS 2010.
class SampleClock {
 public:
  /// @param period [s] nominal, between two samples
  explicit SampleClock(double period) : step_(fromSeconds(period * (1.0 + kDrift))) {}

  /// @param arrival when the sample arrived, less what is known of its delay
  Timestamp stamp(Timestamp arrival) {
    const bool lost = !last_ || arrival - *last_ > kGap;  // samples are missing: begin anew
    last_ = lost ? arrival : std::max(*last_, std::min(arrival, *last_ + step_));
    return *last_;
  }

 private:
  static constexpr double kDrift = 0.005;  // the device's clock against ours, and how fast a late start is made good
  static constexpr Duration kGap = std::chrono::milliseconds(50);
  Duration step_;
  std::optional<Timestamp> last_;
};

}  // namespace slam
