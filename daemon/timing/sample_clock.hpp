// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <optional>

#include "core/timestamp.hpp"

namespace slam {

/// Stamps for samples that a device takes at a steady rate but that arrive late by a varying delay. The least delayed
/// arrivals are the best witnesses: a sample is stamped no later than one period (and a little drift) after its
/// predecessor, and no later than it arrived; when for a while all come later than that, samples went missing unseen,
/// and the least late of them sets the stamps anew. Stamps never go back.
/// [Olson 2010] E. Olson, "A passive solution to the sensor synchronization problem", Proc. IROS 2010.
class SampleClock {
 public:
  /// @param period [s] nominal, between two samples
  explicit SampleClock(double period) : step_(fromSeconds(period * (1.0 + kDrift))) {}

  /// @param arrival when the sample arrived, less what is known of its delay
  /// @param lost    samples that are known to be missing before it
  Timestamp stamp(Timestamp arrival, int lost = 0) {
    if (!last_ || arrival - *last_ - lost * step_ > kGap) return begin(arrival);
    const Timestamp expected = *last_ + (1 + lost) * step_;
    const Duration lag = arrival - expected;
    last_ = std::max(*last_, std::min(arrival, expected));
    least_lag_ = std::min(least_lag_, lag);
    const bool slipped = lag > kSlip && arrival - window_begin_ > kWindow;
    if (slipped) *last_ += least_lag_;
    if (lag <= kSlip || slipped) window_begin_ = arrival, least_lag_ = kGap;
    return *last_;
  }

 private:
  static constexpr double kDrift = 0.005;  // the device's clock against ours, and how fast a late start is made good
  static constexpr Duration kGap = std::chrono::milliseconds(100);     // samples are missing: begin anew
  static constexpr Duration kSlip = std::chrono::microseconds(1500);   // above what kDrift adds up to in a window
  static constexpr Duration kWindow = std::chrono::milliseconds(250);  // some arrival in it is hardly delayed

  Timestamp begin(Timestamp arrival) {
    last_ = window_begin_ = arrival;
    least_lag_ = kGap;
    return arrival;
  }

  Duration step_;
  std::optional<Timestamp> last_;
  Timestamp window_begin_{};   // since then every sample came more than kSlip late
  Duration least_lag_ = kGap;  // among them
};

}  // namespace slam
