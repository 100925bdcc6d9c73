// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <optional>

#include "core/timestamp.hpp"

namespace slam {

/// Maps the clock of a device that stamps its own samples to ours. A sample arrives late by a varying delay, so the
/// smallest difference between arrival and stamp seen so far is the best estimate of the clocks' offset; it is let grow
/// by the clocks' possible drift. What is the same in all delays stays in the result.
/// [Olson 2010] E. Olson, "A passive solution to the sensor synchronization problem", Proc. IROS 2010.
class DeviceClock {
 public:
  /// @param device time since any origin @param arrival of the sample, in our clock
  /// @return when the sample was taken, in our clock
  Timestamp stamp(Duration device, Timestamp arrival) {
    const Duration offset = arrival.time_since_epoch() - device;
    const bool restarted = !last_ || device < *last_ || offset - offset_ > kStep;
    const Duration elapsed = restarted ? Duration(0) : device - *last_;
    const auto drift = Duration(static_cast<Duration::rep>(kDrift * static_cast<double>(elapsed.count())));
    offset_ = restarted ? offset : std::min(offset_ + drift, offset);
    last_ = device;
    return Timestamp(device + offset_);
  }

 private:
  static constexpr double kDrift = 200e-6;                     // [1] two crystals, both at their worst
  static constexpr Duration kStep = std::chrono::seconds(10);  // no delay is that long: the device set its clock
  std::optional<Duration> last_;
  Duration offset_{0};
};

}  // namespace slam
