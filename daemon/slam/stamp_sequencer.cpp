// SPDX-License-Identifier: BSD-3-Clause
#include "slam/stamp_sequencer.hpp"

#include <algorithm>

namespace slam {
namespace {

constexpr double kReset = 5.0;        // [s] a jump back by more is a clock that was set
constexpr double kLeastShare = 0.25;  // of the usual interval, between two stamps
constexpr int kFirstSteps = 5;
constexpr double kMemory = 0.05;       // gain of the running mean
constexpr double kLongestShare = 3.0;  // of the usual interval: longer ones are pauses, not the stream's rate

constexpr double kFarAhead = 3.0;  // [s] a step forward by more needs a second sample to be believed

}  // namespace

bool ForwardJumpGuard::passes(Timestamp recorded) {
  const bool confirmed = held_ && recorded >= *held_ - fromSeconds(kFarAhead);
  if (last_ && toSeconds(recorded - *last_) > std::max(kFarAhead, longest_) && !confirmed) {
    held_ = recorded;
    ++held_count_;
    return false;
  }
  if (confirmed) longest_ = 2.0 * toSeconds(recorded - *held_);  // a stream that is slower than that
  last_ = recorded;
  held_.reset();
  return true;
}

Timestamp ClockStepBridge::next(Timestamp recorded, Timestamp newest) {
  if (last_ && toSeconds(*last_ - recorded) > kReset) shift_ = newest - recorded;
  last_ = recorded;
  return recorded + shift_;
}

Timestamp StampSequencer::next(Timestamp recorded) {
  if (!last_) {
    last_recorded_ = last_ = recorded;
    return recorded;
  }
  if (toSeconds(*last_recorded_ - recorded) > kReset) {
    ++clock_resets_;
    shift_ = *last_ + fromSeconds(interval_) - recorded;
  }
  const double step = std::max(0.0, toSeconds(recorded - *last_recorded_));
  if (steps_ < kFirstSteps) {  // one of them may be a pause
    if (step > 0.0) interval_ = steps_++ == 0 ? step : std::min(interval_, step);
  } else {
    interval_ += kMemory * (std::min(step, kLongestShare * interval_) - interval_);
  }
  last_recorded_ = recorded;

  const Timestamp least = *last_ + std::max(Duration(1), fromSeconds(kLeastShare * interval_));
  Timestamp stamp = recorded + shift_;
  if (stamp < least) {
    stamp = least;
    ++retimed_;
  }
  last_ = stamp;
  return stamp;
}

}  // namespace slam
