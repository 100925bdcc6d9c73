// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "core/pose_history.hpp"
#include "core/samples.hpp"
#include "estimation/ekf.hpp"

namespace slam {

struct EkfTimelineConfig {
  double window = 1.0;    ///< [s] a sample this much older than the newest is still fused at its own stamp
  int capacity = 1024;    ///< samples kept at most; bounds the window at high rates
  double too_soon = 0.5;  ///< [1] of the mean interval before: an interval so short is joined to the next
  double jitter = 0.01;   ///< [s] that stamps are late now and then; what is longer apart was so in truth
  double recent = 0.1;    ///< [s] stamps that are off by half an interval make little speed over so long; a robot
                          ///< brakes within twice of it

  void visitSettings(auto& v) {
    v.expert("window", window, "s", 0.05, 10.0,
             "A sample that is late by no more than this is still fused at its own stamp.");
  }
};

/// Feeds an Ekf in stamp order whatever the order of arrival.
///
/// The newest samples are kept with the filter state after each. A sample that arrives late is put at its place and
/// the filter is run again from there, so the result is the one of the right order. What is older than the window is
/// counted and dropped. Samples of one stamp are used as: matched scan, wheels, IMU, bias.
///
/// The difference of two wheel samples is a mean over the interval between them, so it is fused at the interval's
/// beginning: there it is the velocity that holds until its end, and the dead reckoning over the interval is exact.
/// A sample that comes much sooner than those before it was not taken sooner: they were late. Its interval is joined
/// with theirs, or the speed in it, which holds on when the wheels fall silent, would be that of a jitter in the
/// stamps. Beyond the newest sample holds the mean speed of the last tenth of a second.
///
/// No allocation after construction.
class EkfTimeline {
 public:
  EkfTimeline(const EkfConfig& ekf_config, const EkfTimelineConfig& config);

  UpdateResult add(const WheelSample& sample);
  UpdateResult add(const ImuSample& sample);
  UpdateResult add(const PoseMeasurement& measurement);
  /// What is known of the gyro's bias from elsewhere, from now on: no sample behind it is used anew.
  void add(const GyroBias& bias);

  /// The gyro was wrong: its samples are taken back as far as they are kept.
  void loseGyro();

  /// Forgets all samples and goes on from `pose` at the newest stamp, keeping the gyro bias and its variance.
  void setPose(const Pose2& pose, const Eigen::Vector3d& sigma);

  bool started() const { return started_; }
  /// The map moved: rewrites all states and pose measurements of the window in its new frame, so that late samples are
  /// still fused right. @param T_new_old old map coordinates to new ones
  void transform(const Pose2& T_new_old);

  Timestamp newestStamp() const { return size_ > 0 ? entry(size_ - 1).stamp : base_.stamp(); }
  Timestamp oldestStamp() const { return base_.stamp(); }

  /// State after the newest sample.
  const Ekf& newest() const { return size_ > 0 ? entry(size_ - 1).after : base_; }
  /// State after the newest sample up to `stamp`; the oldest state if it is too early.
  const Ekf& upTo(Timestamp stamp) const;
  /// Filter state at `stamp`, predicted forward from the newest sample before it; the oldest state if it is too early.
  Ekf at(Timestamp stamp) const;
  /// Its pose, without a copy of the filter.
  Pose2 poseAt(Timestamp stamp) const { return upTo(stamp).poseAt(stamp); }
  /// Poses from `from` to `to`, both included, at each sample between.
  void fillHistory(Timestamp from, Timestamp to, PoseHistory& history) const;

  std::uint32_t lateFused() const { return late_fused_; }
  std::uint32_t tooOld() const { return too_old_; }

 private:
  using Sample =
      std::variant<PoseMeasurement, WheelSample, ImuSample, GyroBias>;  // in the order of use at equal stamps
  struct Entry {
    Timestamp stamp;
    Sample sample;
    Ekf after;  // state once this sample is used
    UpdateResult result = UpdateResult::kUseless;
    bool joined = false;  // of wheels: the interval that ends here began before the wheel sample before it
  };

  struct Interval {
    std::size_t begin;
    int samples;  // in it, without the first
  };

  UpdateResult insert(Timestamp stamp, const Sample& sample);
  void makeRoom(Timestamp newest);
  void popOldest();
  std::size_t joinIntervals(std::size_t from);
  void run(std::size_t first);
  UpdateResult apply(std::size_t i, Ekf& ekf) const;
  Twist2 meanTwist(std::size_t begin, std::size_t end) const;
  std::optional<Twist2> recentTwist(std::size_t end) const;
  std::optional<std::size_t> wheelsBefore(std::size_t end) const;
  std::optional<std::size_t> wheelsFrom(std::size_t begin) const;
  std::optional<Interval> intervalBefore(std::size_t end) const;
  std::optional<std::size_t> intervalFrom(std::size_t begin) const;
  bool cameTooSoon(std::size_t i) const;  // so that the wheel samples before must have been late
  Entry& entry(std::size_t i) { return ring_[(begin_ + i) % ring_.size()]; }
  const Entry& entry(std::size_t i) const { return ring_[(begin_ + i) % ring_.size()]; }

  std::unique_ptr<const EkfConfig> ekf_config_;  // at a fixed address: the filter states refer to it
  EkfTimelineConfig config_;
  std::vector<Entry> ring_;
  std::size_t begin_ = 0, size_ = 0;
  Ekf base_;  // state before the oldest entry
  bool started_ = false;
  std::uint32_t late_fused_ = 0, too_old_ = 0;
};

}  // namespace slam
