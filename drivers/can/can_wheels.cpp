// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_wheels.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace slam {
namespace {

using namespace std::chrono_literals;

// Each at least, and longer with the period at which a drive sends.
constexpr Duration kSilence = 500ms;     // a drive that was silent longer may have been reset meanwhile
constexpr Duration kApart = 50ms;        // readings of the two wheels further apart make no pair
constexpr Duration kInterpolate = 50ms;  // readings of one wheel further apart say nothing of what is between
constexpr double kSlack = 0.5;           // [rad] of jitter in the stamps and of the encoder's filter ...
constexpr double kBending = 4.0;         // [rad/s^2] ... and of a speed that changes between two estimates

/// A little more than so many periods.
Duration periods(int count, Duration period) { return count * period + period / 4; }

}  // namespace

bool CanWheel::follows(const Count& before, const Count& now) const {
  const double dt = toSeconds(now.stamp - before.stamp);
  return now.stamp - before.stamp <= std::max(kSilence, periods(2, period())) &&
         std::abs(now.angle - before.angle - 0.5 * (before.speed + now.speed) * dt) <= kSlack + kBending * dt * dt;
}

bool CanWheel::trust(const Count& now) {
  const bool possible = std::abs(now.speed) <= max_speed_;
  const bool in_line = possible && (!newest_ || follows(*newest_, now));
  in_line_ = in_line ? std::min(in_line_ + 1, kTrusted) : 0;
  if (possible) newest_ = now;
  return in_line_ == kTrusted;
}

CanWheel::Outcome CanWheel::add(Timestamp stamp, const can::odrive::EncoderEstimates& estimates) {
  const Count count{stamp, scale_ * static_cast<double>(estimates.position),
                    scale_ * static_cast<double>(estimates.velocity)};
  if (newest_ && stamp <= newest_->stamp) return Outcome::kStepsBack;
  const bool trusted = trust(count), goes_on = trusted && count_ && follows(*count_, count);
  pace_.add(stamp);  // a silence is none to this estimate yet
  if (!trusted) return Outcome::kRejected;

  const double turned = goes_on ? count.angle - count_->angle : 0.0;
  previous_ = goes_on ? std::optional(last_) : std::nullopt;
  last_ = {stamp, last_.angle + turned, count.speed};
  count_ = count;
  return goes_on ? Outcome::kGoodOn : Outcome::kGoodAnew;
}

double CanWheel::angleAt(Timestamp stamp) const {
  const double back = toSeconds(last_.stamp - stamp);  // [s]
  if (!previous_ || previous_->stamp > stamp ||
      last_.stamp - previous_->stamp > std::max(kInterpolate, periods(1, period())))
    return last_.angle - last_.speed * back;
  // Cubic through both angles with both speeds.
  const double span = toSeconds(last_.stamp - previous_->stamp), u = 1.0 - back / span;
  const double u2 = u * u, u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * previous_->angle + (u3 - 2 * u2 + u) * span * previous_->speed +
         (3 * u2 - 2 * u3) * last_.angle + (u3 - u2) * span * last_.speed;
}

CanWheels::CanWheels(const CanWheelsConfig& config)
    : wheels_{CanWheel(2.0 * std::numbers::pi * config.sign[0] / config.gear_ratio, config.max_speed),
              CanWheel(2.0 * std::numbers::pi * config.sign[1] / config.gear_ratio, config.max_speed)} {}

std::optional<CanWheels::Pair> CanWheels::add(std::size_t side, Timestamp stamp,
                                              const can::odrive::EncoderEstimates& estimates) {
  const auto outcome = wheels_[side].add(stamp, estimates);
  if (outcome == CanWheel::Outcome::kRejected || outcome == CanWheel::Outcome::kStepsBack) {
    ++rejects_;
    return std::nullopt;
  }
  if (outcome == CanWheel::Outcome::kGoodAnew) restarted_ = true;
  fresh_[side] = true;
  const auto& left = wheels_[0].last();
  const auto& right = wheels_[1].last();
  if (!fresh_[0] || !fresh_[1]) return std::nullopt;
  const Duration longest = std::max(wheels_[0].period(), wheels_[1].period());
  if (std::chrono::abs(left.stamp - right.stamp) > std::max(kApart, periods(1, longest))) return std::nullopt;
  fresh_ = {};
  const Timestamp instant = std::min(left.stamp, right.stamp);
  return Pair{instant, {wheels_[0].angleAt(instant), wheels_[1].angleAt(instant)}, std::exchange(restarted_, false)};
}

}  // namespace slam
