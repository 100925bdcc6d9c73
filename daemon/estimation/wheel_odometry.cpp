// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/wheel_odometry.hpp"

#include <algorithm>

#include "core/plausibility.hpp"

namespace slam {

const Pose2& WheelOdometry::add(std::span<const double> angles) {
  slip_ = 0.0;
  const bool two_axles = base_.type == BaseType::kDifferential && angles.size() == 4;
  const bool plausible =
      std::all_of(angles.begin(), angles.end(), [](double angle) { return isWithin(angle, kPlausible.dead_reckoned); });
  if (!plausible || (angles.size() != static_cast<std::size_t>(wheelCount(base_.type)) && !two_axles)) {
    restart();
    return pose_;
  }
  Reading reading{{}, angles.size()};
  std::copy(angles.begin(), angles.end(), reading.angles.begin());
  if (last_ && last_->count == reading.count) {
    WheelVector turned{};  // [rad]
    for (std::size_t i = 0; i < reading.count; ++i) turned[i] = reading.angles[i] - last_->angles[i];
    const std::span<const double> step(turned.data(), reading.count);
    const Pose2 next = pose_ * exp(twistOf(base_, step));
    if (isPlausible(WheelSample{{}, next})) pose_ = next;
    slip_ = unexplained(base_, step);
  }
  last_ = reading;
  return pose_;
}

}  // namespace slam
