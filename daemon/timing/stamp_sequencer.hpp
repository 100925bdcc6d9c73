// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>

#include "core/timestamp.hpp"

namespace slam {

/// What a stream's stamps may do and still be those of one clock.
struct StampConfig {
  double far_ahead = 3.0;        ///< [s] a step forward by more needs a second sample to be believed
  double ahead_of_others = 0.5;  ///< [s] nor is any stream so far ahead of the others for one sample, while these go on
  int usual_lead = 3;            ///< such samples in a row: it always is
  double set_back = 5.0;         ///< [s] a jump back by more is a clock that was set
  double least_step = 0.25;      ///< [1] of the usual interval, between two stamps
  int first_steps = 5;           ///< of which the shortest is the usual interval; then it is a running mean ...
  double memory = 0.05;          ///< [1] ... of this gain ...
  double longest_share = 3.0;    ///< [1] ... in which no step counts for more intervals: it was a pause
};

/// Holds back a sample whose stamp is seconds ahead of its stream until the next one confirms it: a single damaged
/// stamp must not make everything after it look old. Where other streams go on meanwhile, tenths of a second ahead of
/// them are too many, until three in a row confirm them.
class ForwardJumpGuard {
 public:
  explicit ForwardJumpGuard(const StampConfig& config = {}) : config_(config) {}

  /// @param others newest stamp of the other streams; none: there are none
  /// @return false for a sample that must not be used
  bool passes(Timestamp recorded, std::optional<Timestamp> others = {});
  std::optional<Timestamp> last() const { return last_; }
  std::uint32_t held() const { return held_count_; }

 private:
  StampConfig config_;
  bool leads(Timestamp recorded, std::optional<Timestamp> others);

  std::optional<Timestamp> last_, held_;
  double longest_ = 0.0;       // [s] between two samples of the stream, as confirmed
  double longest_step_ = 0.0;  // [s] between two samples that passed
  double lead_ = 0.0;          // [s] before the other streams, as confirmed
  int leading_ = 0;            // samples in a row that are further ahead
  std::uint32_t held_count_ = 0;
};

/// Carries a stream on whose clock was set back by seconds, without touching the order of its stamps otherwise.
class ClockStepBridge {
 public:
  explicit ClockStepBridge(const StampConfig& config = {}) : config_(config) {}

  /// @param newest stamp of any stream so far, as carried on
  Timestamp next(Timestamp recorded, Timestamp newest);

 private:
  StampConfig config_;
  std::optional<Timestamp> last_;
  Duration shift_{0};
};

/// Makes the stamps of one sensor's stream increase, in the order the samples came.
///
/// Recorded logs have stamps that go back by tenths of a second or nearly coincide, though their samples are in order.
/// A stamp that is not at least a quarter of the usual interval after its predecessor is moved there; the stream
/// catches up as soon as the recorded stamps are ahead again. A jump back by more than `set_back` is a clock that was
/// set: from then on stamps are shifted so that time goes on.
class StampSequencer {
 public:
  explicit StampSequencer(const StampConfig& config = {}) : config_(config) {}

  Timestamp next(Timestamp recorded);

  /// [s] between two samples in the mean; 0 before the second one.
  double interval() const { return interval_; }
  std::uint32_t retimed() const { return retimed_; }
  std::uint32_t clockResets() const { return clock_resets_; }

 private:
  StampConfig config_;
  std::optional<Timestamp> last_recorded_, last_;
  Duration shift_{0};
  double interval_ = 0.0;  // [s] running mean, once some steps were seen; before, the shortest of them
  int steps_ = 0;
  std::uint32_t retimed_ = 0, clock_resets_ = 0;
};

}  // namespace slam
