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

/// Which speed a base gets when, and what a stop that is owed means: a zero, sent again and again until the base is
/// known to have it. It is owed behind each speed that was sent, and whenever the base may turn by a speed that is not
/// known here: its port was opened, it was reset, an answer did not come. A fresh command goes before it.
class SpeedDuty {
 public:
  /// @param period between two speeds; the first zero does not wait
  SpeedDuty(bool may_drive, const SpeedLimits& limits, Duration period)
      : may_drive_(may_drive), period_(period), command_(limits) {}

  /// As SpeedCommand::give(); false also where the base may not be driven.
  bool give(const Twist2& twist, Timestamp given) { return may_drive_ && command_.give(twist, given); }
  std::uint64_t limited() const { return command_.limited(); }

  // From the thread that drives:

  void owe() { owed_ = may_drive_; }
  bool isOwed() const { return owed_; }
  /// Whether there is a command that lasts.
  bool drives(Timestamp now) { return command_.at(now).has_value(); }
  /// What was given until now is not driven any more.
  void revoke(Timestamp now) { command_.revoke(now); }
  /// The speed that must be sent now: nothing, a command, or the zero that is owed.
  std::optional<Twist2> due(Timestamp now) {
    const std::optional<Twist2> twist = command_.at(now);
    const bool waits = (twist || is_zero_) && now < next_;  // the first zero does not
    if (waits || (!twist && !owed_)) return std::nullopt;
    owed_ = true;
    is_zero_ = !twist;
    next_ = now + period_;
    return twist.value_or(Twist2{});
  }
  /// The base is known to have the speed that was sent last.
  void acknowledge() { owed_ = owed_ && !is_zero_; }
  /// At the end a zero is sent outside of due(). @param first no answer to another speed can still come
  void sendZero(bool first) { is_zero_ = is_zero_ || first; }

 private:
  bool may_drive_;
  Duration period_;
  SpeedCommand command_;
  bool owed_ = false, is_zero_ = false;  // the latter: the speed that was sent last
  Timestamp next_{};
};

}  // namespace slam
