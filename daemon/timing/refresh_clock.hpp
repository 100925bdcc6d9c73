// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "core/timestamp.hpp"
#include "timing/lower_envelope.hpp"

namespace slam {

/// When to ask next: at a mean rate, but at phases that wander, so that requests close in on a renewal from both sides
/// even where the asking thread runs at a multiple of the device's rate.
class PollSchedule {
 public:
  explicit PollSchedule(Duration period) : period_(period) {}
  Timestamp due() const { return due_; }
  /// The request that was due has been sent.
  void advance(Timestamp now) {
    begin_ = std::max(begin_ + period_, now - period_);
    phase_ += kGoldenSection - (phase_ + kGoldenSection >= 1.0 ? 1.0 : 0.0);
    due_ = begin_ + Duration(static_cast<Duration::rep>(kSpread * phase_ * static_cast<double>(period_.count())));
  }

 private:
  static constexpr double kGoldenSection = 0.6180339887498949;  // its multiples modulo 1 are spread evenly
  static constexpr double kSpread = 0.5;                        // [1] of the period
  Duration period_;
  Timestamp begin_{}, due_{};
  double phase_ = 0.0;  // [1]
};

/// Finds out when a device that has no clock to read, and is asked now and then, renews its values.
///
/// A new value was taken after the last request that still got the one before it, and not after the answer that brought
/// it: that holds whatever the delays are. With requests at ever other phases of the device's period the least delayed
/// ones close in on the instant from both sides. The period is one of two that the firmware uses; which one, and its
/// exact length, is learned. Requests must come more often than the period, or nothing can be told.
class RefreshClock {
 public:
  /// Of one request that brought a new value.
  struct Change {
    Timestamp old_asked;  ///< when the last request was sent that got the value before
    Timestamp asked;      ///< when this one was sent
    Timestamp answered;   ///< when its answer was read
  };

  /// @return when the device took the new value; std::nullopt: not known yet
  std::optional<Timestamp> stamp(const Change& change);
  /// The device was reset.
  void restart();
  bool locked() const { return locked_.has_value(); }

 private:
  struct Candidate {
    Duration period;
    Timestamp earliest{}, latest{};  // of the present renewal
    int changes = 0;
  };
  struct Lock {
    LowerEnvelope before, after;  // of the requests too early (times negated) and late enough
    std::int64_t index = 0;       // of the renewal stamped last
    Timestamp last;
    int contradictions = 0;
  };

  void learn(const Change& change);
  Timestamp follow(Lock& lock, const Change& change);

  std::array<Candidate, 2> candidates_{Candidate{std::chrono::milliseconds(20)},
                                       Candidate{std::chrono::milliseconds(50)}};
  std::optional<Lock> locked_;
};

}  // namespace slam
