// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"

namespace slam::sim {

/// A lidar at byte level, of whatever make. Pure: time and ranges come from outside.
class EmulatedLidar {
 public:
  /// Range [m] measured at an instant and bearing [rad, counter-clockwise], 0 without return.
  using Measure = std::function<double(Timestamp, double bearing)>;
  virtual ~EmulatedLidar() = default;

  /// Bytes from the host. @param out answers are appended
  virtual void receive(std::span<const std::uint8_t> bytes, Timestamp now, std::vector<std::uint8_t>& out) = 0;
  /// Appends the bytes that have come through the line by `now`.
  virtual void stream(Timestamp now, std::vector<std::uint8_t>& out) = 0;
  /// Lets something go wrong from the next call on; kinds and values are those of LidarFaults.
  /// @return false for an unknown kind or a bad value
  virtual bool inject(std::string_view kind, double value) = 0;
  virtual bool scanning() const = 0;
};

}  // namespace slam::sim
