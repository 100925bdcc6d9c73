// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/estimates.hpp"
#include "core/timestamp.hpp"
#include "drivers/latest_triple.hpp"

namespace slam {

/// The twist that a base was asked for last, from who gives it to the thread that drives, without waiting. It lasts for
/// less than half a second; where at() has none a driver owes the wheels a stop.
class SpeedCommand {
 public:
  /// Of a twist. A driver sends each 20 to 50 ms, so the zero that follows is on its way within half a second.
  static constexpr Duration kLasts = std::chrono::milliseconds(450);

  explicit SpeedCommand(const SpeedLimits& limits) : limits_(limits) {}

  /// From one thread. Above the limits it is made slower, and counted. @param given when; not later than now
  /// @return false: it is not finite, and nothing has changed
  bool give(const Twist2& twist, Timestamp given) {
    if (!std::isfinite(twist.vx) || !std::isfinite(twist.vy) || !std::isfinite(twist.omega)) return false;
    const double factor = limits_.factor(twist);
    if (factor < 1.0) limited_.fetch_add(1, std::memory_order_relaxed);
    command_.store({{factor * twist.vx, factor * twist.vy, factor * twist.omega}, given.time_since_epoch().count()});
    return true;
  }

  // From the thread that drives:

  std::optional<Twist2> at(Timestamp now) {
    const auto& [numbers, time] = command_.load();
    const Timestamp given{Duration(time)};
    if (time == 0 || now - given > kLasts || given <= revoked_) return std::nullopt;
    return Twist2{numbers[0], numbers[1], numbers[2]};
  }
  /// When the last one was given; it may be revoked.
  Timestamp given() { return Timestamp{Duration(command_.load().time)}; }
  /// What was given until now is not driven any more.
  void revoke(Timestamp now) { revoked_ = now; }

  std::uint64_t limited() const { return limited_.load(std::memory_order_relaxed); }  ///< twists above the limits

 private:
  SpeedLimits limits_;
  LatestTriple command_;
  std::atomic<std::uint64_t> limited_{0};
  Timestamp revoked_{};
};

}  // namespace slam
