// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/timestamp.hpp"
#include "timing/lower_envelope.hpp"

namespace slam {

/// Stamps for samples that a device sends unasked, at a steady rate that nobody told us: the rate is learned from the
/// first samples, then the least delayed arrivals say when the samples were taken. What is the same in all delays stays
/// in the result. Stamps never go back.
class StreamClock {
 public:
  /// @param lost  samples between this one and the one before are known to be lost
  Timestamp stamp(Timestamp arrival, bool lost = false) {
    if (!first_ || arrival - last_arrival_ > gap()) begin(arrival);
    last_arrival_ = arrival;
    if (lost && envelope_ && index_ > begun_) {
      index_ += missing(arrival);
      envelope_->forget();
    }
    const std::int64_t time = arrival.time_since_epoch().count();
    std::int64_t taken = time;
    if (envelope_) {
      envelope_->add(index_, time);
      taken = envelope_->at(index_);
    } else if (index_ >= kLearn && arrival - *first_ < kLearn * kShortestPeriod) {
      begin(arrival);  // they had been held up: nothing can be learned of them
    } else if (index_ >= kLearn) {
      const double period = static_cast<double>((arrival - *first_).count()) / static_cast<double>(index_);
      envelope_.emplace(period);
      envelope_->add(index_, time);
      begun_ = index_;
    }
    ++index_;
    last_ = std::max(last_, std::min(arrival, Timestamp(Duration(taken))));
    delay_ += kDelayGain * (static_cast<double>((arrival - last_).count()) - delay_);
    return last_;
  }
  bool learned() const { return envelope_.has_value(); }
  double period() const { return 1e-9 * envelope_->period(); }  ///< [s] once it is learned

 private:
  static constexpr std::int64_t kLearn = 64;  // samples
  static constexpr double kDelayGain = 0.02;  // [1] of the mean delay's filter
  static constexpr Duration kShortestPeriod = std::chrono::microseconds(500);
  static constexpr Duration kShortestGap = std::chrono::milliseconds(100);

  Duration gap() const {
    const double period = envelope_ ? envelope_->period() : 0.0;
    return std::max(kShortestGap, Duration(static_cast<Duration::rep>(5.0 * period)));
  }
  void begin(Timestamp arrival) {
    if (envelope_) envelope_.emplace(envelope_->period());
    first_ = arrival;
    index_ = begun_ = 0;
  }
  /// Samples that fit between the last one and this, if this is as late as samples are.
  std::int64_t missing(Timestamp arrival) const {
    const double late = static_cast<double>(arrival.time_since_epoch().count() - envelope_->at(index_)) - delay_;
    return std::max<std::int64_t>(0, std::llround(late / envelope_->period()));
  }

  std::optional<LowerEnvelope> envelope_;
  std::optional<Timestamp> first_;
  Timestamp last_arrival_{}, last_{};
  std::int64_t index_ = 0, begun_ = 0;
  double delay_ = 0.0;  // [ns] mean, of arrivals behind their stamps
};

}  // namespace slam
