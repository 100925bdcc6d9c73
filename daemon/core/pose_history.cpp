// SPDX-License-Identifier: BSD-3-Clause
#include "core/pose_history.hpp"

#include <algorithm>
#include <cassert>

namespace slam {

Pose2 interpolate(const Pose2& from, const Pose2& to, double fraction) {
  return from * exp(fraction * log(between(from, to)));
}

PoseHistory::PoseHistory(std::size_t capacity) : ring_(capacity) { assert(capacity >= 2); }

bool PoseHistory::push(Timestamp stamp, const Pose2& pose) {
  if (size_ > 0 && stamp < newest().stamp) return false;
  if (size_ > 0 && stamp == newest().stamp) {
    ring_[(begin_ + size_ - 1) % ring_.size()].pose = pose;
    return true;
  }
  if (size_ == ring_.size()) {
    begin_ = (begin_ + 1) % ring_.size();
    --size_;
  }
  ring_[(begin_ + size_) % ring_.size()] = {stamp, pose};
  ++size_;
  return true;
}

std::optional<Pose2> PoseHistory::at(Timestamp stamp, Duration extrapolation) const {
  if (size_ == 0) return std::nullopt;
  const bool before = stamp<(*this)[0].stamp, after = stamp> newest().stamp;
  if (before && (*this)[0].stamp - stamp > extrapolation) return std::nullopt;
  if (after && stamp - newest().stamp > extrapolation) return std::nullopt;
  if (size_ == 1) return (*this)[0].pose;

  std::size_t low = 0, high = size_ - 1;  // ring[low].stamp <= stamp < ring[high].stamp, or the nearest pair outside
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    ((*this)[middle].stamp <= stamp ? low : high) = middle;
  }
  const StampedPose &a = (*this)[low], &b = (*this)[high];
  return interpolate(a.pose, b.pose, toSeconds(stamp - a.stamp) / toSeconds(b.stamp - a.stamp));
}

}  // namespace slam
