// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/scan.hpp"

namespace slam {

/// Notices a lidar that repeats a turn: to the last bit the same range at the same bearing, turn after turn, which the
/// noise of no lidar does for most of its beams.
class ScanRepeatWatch {
 public:
  /// @return whether the lidar is stuck
  bool isStuck(const LaserScan& scan) {
    int compared = 0, equal = 0;
    for (const Beam& beam : scan.beams()) {
      if (!scan.isReturn(beam)) continue;
      const double turns = 0.5 + 0.5 * static_cast<double>(beam.bearing) / std::numbers::pi;
      const auto bin = static_cast<std::size_t>((turns - std::floor(turns)) * kBins);
      float& seen = ranges_[std::min(bin, kBins - 1)];
      compared += seen > 0.0F;
      equal += seen == beam.range;
      seen = beam.range;
    }
    const bool repeats = compared >= kFewest && equal > kMost * compared;
    is_copy_ = compared >= kFewest && equal == compared;
    const bool was_stuck = repeats_ >= kTurns;
    repeats_ = repeats ? repeats_ + 1 : 0;
    return was_stuck || repeats_ >= kTurns;  // the turn in which it ends is old in part
  }

  /// Whether the scan looked at last shows what the one before it did, to the last bit.
  bool isCopy() const { return is_copy_; }

 private:
  static constexpr std::size_t kBins = 2880;  // of an eighth of a degree
  static constexpr int kFewest = 50;          // beams that can be compared
  static constexpr double kMost = 0.7;        // [1] of them that are equal by chance: coarse steps, walls near by
  static constexpr int kTurns = 2;
  std::array<float, kBins> ranges_{};  // [m] seen last; 0: nothing yet
  int repeats_ = 0;
  bool is_copy_ = false;
};

}  // namespace slam
