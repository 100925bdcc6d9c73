// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "core/scan.hpp"

namespace slam {

struct RangeNoiseConfig {
  double most = 0.15;  ///< [m] three of match.kernel_scale: three returns of four are taken for other objects
  int fewest = 20;     ///< bearings of a scan that tell it
};

/// Measures the noise of the lidar's ranges while the robot stands still, where each bearing shows the same place. A
/// second difference of three scans in a row leaves out a motion that wheels and gyro do not report, the median what
/// moves in view, and the least of three such measurements a sudden change: a robot that is carried away. Only the
/// nearer half of the bearings counts: noise that grows with range leaves near walls to match.
///
/// No thread, clock or I/O; after construction no allocation.
class RangeNoiseWatch {
 public:
  explicit RangeNoiseWatch(const RangeNoiseConfig& config = {}) : config_(config) {}

  /// @param at_rest by wheels and gyro
  void add(std::span<const Beam> beams, const RangeLimits& limits, bool at_rest);

  /// [m] standard deviation of one range, at least; 0: not known, or none
  double sigma() const { return *std::min_element(newest_.begin(), newest_.end()); }
  /// Scans say nothing of where the robot is.
  bool tooNoisy() const { return sigma() > config_.most; }

 private:
  using Ranges = std::array<float, 720>;  // [m] the shortest in each half degree; 0: none

  struct Spread {
    float range, difference;  // [m]
  };
  /// @return [m] of the newest scan with the two before it; nothing: too few bearings have all three
  std::optional<double> measure();

  RangeNoiseConfig config_;
  std::array<Ranges, 3> scans_{};  // the newest first
  std::array<Spread, 720> spreads_{};
  std::array<double, 3> newest_{};  // [m] measurements, the newest first
  int at_rest_ = 0;                 // scans in a row
};

}  // namespace slam
