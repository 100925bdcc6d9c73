// SPDX-License-Identifier: BSD-3-Clause
#include "timing/stamp_sequencer.hpp"

#include <algorithm>

namespace slam {
namespace {

constexpr double kNoPause = 10.0;  // [1] of the longest step so far: more than a pause of all streams at once

}  // namespace

/// Whether the stamp is ahead of streams that have gone on since the last sample of this one, or were as far as it and
/// are not known to pause with it.
bool ForwardJumpGuard::leads(Timestamp recorded, std::optional<Timestamp> others) {
  if (!last_ || !others || *others < *last_) return false;
  if (*others == *last_ && toSeconds(recorded - *last_) <= kNoPause * longest_step_) return false;
  const double lead = toSeconds(recorded - *others);
  if (lead <= lead_ + config_.ahead_of_others) {
    leading_ = 0;
    lead_ = std::clamp(lead, 0.0, lead_);
    return false;
  }
  if (++leading_ <= config_.usual_lead) return true;
  leading_ = 0;
  lead_ = lead;
  return false;
}

bool ForwardJumpGuard::passes(Timestamp recorded, std::optional<Timestamp> others) {
  if (leads(recorded, others)) {
    ++held_count_;
    return false;
  }
  const bool confirmed = held_ && recorded >= *held_ - fromSeconds(config_.far_ahead);
  if (last_ && toSeconds(recorded - *last_) > std::max(config_.far_ahead, longest_) && !confirmed) {
    held_ = recorded;
    ++held_count_;
    return false;
  }
  if (confirmed) longest_ = 2.0 * toSeconds(recorded - *held_);  // a stream that is slower than that
  if (last_) longest_step_ = std::max(longest_step_, toSeconds(recorded - *last_));
  last_ = recorded;
  held_.reset();
  return true;
}

Timestamp ClockStepBridge::next(Timestamp recorded, Timestamp newest) {
  if (last_ && toSeconds(*last_ - recorded) > config_.set_back) shift_ = newest - recorded;
  last_ = recorded;
  return recorded + shift_;
}

Timestamp StampSequencer::next(Timestamp recorded) {
  if (!last_) {
    last_recorded_ = last_ = recorded;
    return recorded;
  }
  if (toSeconds(*last_recorded_ - recorded) > config_.set_back) {
    ++clock_resets_;
    shift_ = *last_ + fromSeconds(interval_) - recorded;
  }
  const double step = std::max(0.0, toSeconds(recorded - *last_recorded_));
  if (steps_ < config_.first_steps) {  // one of them may be a pause
    if (step > 0.0) interval_ = steps_++ == 0 ? step : std::min(interval_, step);
  } else {
    interval_ += config_.memory * (std::min(step, config_.longest_share * interval_) - interval_);
  }
  last_recorded_ = recorded;

  const Timestamp least = *last_ + std::max(Duration(1), fromSeconds(config_.least_step * interval_));
  Timestamp stamp = recorded + shift_;
  if (stamp < least) {
    stamp = least;
    ++retimed_;
  }
  last_ = stamp;
  return stamp;
}

}  // namespace slam
