// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "core/timestamp.hpp"
#include "timing/device_clock.hpp"

namespace slam {

/// Instants of the 32-bit clock of a base, which wraps, and begins at 0 when the base was reset: then its counters do,
/// too.
class DeviceTime {
 public:
  struct Stamp {
    Timestamp stamp;         ///< in our clock
    bool restarted = false;  ///< the base was reset, or was silent for so long that it may have been
  };
  /// @param tick of the clock
  explicit DeviceTime(Duration tick) : tick_(tick) {}

  Stamp add(std::uint32_t ticks, Timestamp arrival);

 private:
  Duration tick_, time_{0};  // the latter: since the first stamp
  std::uint32_t last_ = 0;   // [ticks]
  bool known_ = false;       // the former
  DeviceClock clock_;
};

}  // namespace slam
