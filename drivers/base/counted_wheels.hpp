// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <optional>

#include "core/timestamp.hpp"
#include "drivers/base/wheel_angles.hpp"

namespace slam {

/// Angles of two wheels from the counts of their encoders, which wrap. A difference that no wheel can have turned, and
/// one over a silence in which the base may have been reset, begins anew. While a wheel hangs in the air the angles
/// stay what they are: it turns, and the robot does not.
class CountedWheels {
 public:
  /// @param bits of the counters: 16 or 32 @param fastest [rad/s] above what a wheel can do
  CountedWheels(double counts_per_turn, int bits, double fastest)
      : per_count_(2.0 * std::numbers::pi / counts_per_turn), unused_(32 - bits), fastest_(fastest) {}

  /// The next counts are no difference to those before.
  void restart() { last_.reset(); }

  WheelAngles add(Timestamp stamp, const std::array<std::uint32_t, 2>& counts, bool lifted) {
    WheelAngles angles{.stamp = stamp, .restarted = !last_, .lifted = lifted};
    if (last_) {
      std::array<std::int64_t, 2> turned{};
      for (std::size_t i = 0; i < 2; ++i) turned[i] = difference(counts[i], last_->counts[i]);
      angles.restarted = !isPossible(turned, toSeconds(stamp - last_->stamp));
      if (!angles.restarted && !lifted && !last_->lifted)
        for (std::size_t i = 0; i < 2; ++i) total_[i] += turned[i];
    }
    last_ = Reading{stamp, counts, lifted};
    for (std::size_t i = 0; i < 2; ++i) angles.angles[i] = per_count_ * static_cast<double>(total_[i]);
    return angles;
  }

 private:
  static constexpr double kJitter = 0.1;   // [s] of the age of a reading
  static constexpr double kSilence = 0.5;  // [s] no base restarts and counts again so soon
  struct Reading {
    Timestamp stamp;
    std::array<std::uint32_t, 2> counts;
    bool lifted;
  };

  /// The shorter way around.
  std::int64_t difference(std::uint32_t now, std::uint32_t before) const {
    return static_cast<std::int32_t>((now - before) << unused_) >> unused_;
  }
  bool isPossible(const std::array<std::int64_t, 2>& turned, double time) const {
    const double most = fastest_ * (time + kJitter) / per_count_;  // [counts]
    if (time < 0.0 || time > kSilence) return false;
    return static_cast<double>(std::abs(turned[0])) <= most && static_cast<double>(std::abs(turned[1])) <= most;
  }

  double per_count_;  // [rad]
  int unused_;        // bits of a 32-bit number
  double fastest_;    // [rad/s]
  std::optional<Reading> last_;
  std::array<std::int64_t, 2> total_{};  // [counts]
};

}  // namespace slam
