// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "core/scan.hpp"

namespace slam {

struct ScanRepeatConfig {
  int fewest = 50;      ///< beams that can be compared
  double most = 0.7;    ///< [1] of them that are equal by chance: coarse steps, walls near by
  int stuck_turns = 2;  ///< repeated in a row
};

/// Notices a lidar that repeats a turn: to the last bit the same range at the same bearing, turn after turn, which the
/// noise of no lidar does for most of its beams.
class StuckScanDetector {
 public:
  explicit StuckScanDetector(const ScanRepeatConfig& config = {}) : config_(config) {}

  /// @param codes written where nothing came back [m]: they repeat in any scan
  /// @return whether the lidar is stuck
  bool isStuck(const LaserScan& scan, std::span<const float> codes = {}) {
    int compared = 0, equal = 0;
    for (const Beam& beam : scan.beams()) {
      if (!scan.isReturn(beam) || std::find(codes.begin(), codes.end(), beam.range) != codes.end()) continue;
      const double turns = 0.5 + 0.5 * static_cast<double>(beam.bearing) / std::numbers::pi;
      const auto bin = static_cast<std::size_t>((turns - std::floor(turns)) * kBins);
      float& seen = ranges_[std::min(bin, kBins - 1)];
      compared += seen > 0.0F;
      equal += seen == beam.range;
      seen = beam.range;
    }
    const bool repeats = compared >= config_.fewest && equal > config_.most * compared;
    is_repeat_ = compared >= config_.fewest && equal == compared;
    const bool was_stuck = repeats_ >= config_.stuck_turns;
    repeats_ = repeats ? repeats_ + 1 : 0;
    return was_stuck || repeats_ >= config_.stuck_turns;  // the turn in which it ends is old in part
  }

  /// Whether the scan looked at last shows what the one before it did, to the last bit.
  bool isRepeat() const { return is_repeat_; }

 private:
  static constexpr std::size_t kBins = 2880;  // of an eighth of a degree
  ScanRepeatConfig config_;
  std::array<float, kBins> ranges_{};  // [m] seen last; 0: nothing yet
  int repeats_ = 0;
  bool is_repeat_ = false;
};

}  // namespace slam
