// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "core/pose2.hpp"
#include "core/timestamp.hpp"

namespace slam {

struct StampedPose {
  Timestamp stamp;
  Pose2 pose;
};

/// Interpolates along the constant twist that joins two poses. @param fraction 0 gives `from`, 1 gives `to`
Pose2 interpolate(const Pose2& from, const Pose2& to, double fraction);

/// The newest poses of a moving frame, in stamp order, in a ring of fixed capacity (no allocation after construction).
class PoseHistory {
 public:
  explicit PoseHistory(std::size_t capacity);

  void clear() { begin_ = size_ = 0; }
  /// Adds a pose later than all others; an equal stamp replaces the newest pose. @return false, unchanged, if earlier
  bool push(Timestamp stamp, const Pose2& pose);

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const StampedPose& operator[](std::size_t i) const { return ring_[(begin_ + i) % ring_.size()]; }
  const StampedPose& newest() const { return (*this)[size_ - 1]; }

  /// @return the pose at `stamp`, interpolated; beyond either end by less than `extrapolation` at the twist of the
  ///         nearest pair, and std::nullopt further out or when there are no poses
  std::optional<Pose2> at(Timestamp stamp, Duration extrapolation = Duration::zero()) const;

 private:
  std::vector<StampedPose> ring_;
  std::size_t begin_ = 0;
  std::size_t size_ = 0;
};

}  // namespace slam
