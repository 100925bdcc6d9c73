// SPDX-License-Identifier: BSD-3-Clause
#include "tools/faults/sensor_faults.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slam {

void LidarMountFault::apply(LaserScan& scan) const {
  for (int i = 0; i < scan.size; ++i) {
    float& bearing = scan.storage[static_cast<std::size_t>(i)].bearing;
    if (upside_down) bearing = -bearing;
    if (turned) bearing = static_cast<float>(wrapAngle(bearing + std::numbers::pi));
  }
}

FaultyWheels::FaultyWheels(const WheelFault& fault, std::uint64_t seed, std::int64_t first, std::int64_t last)
    : fault_(fault), random_(seed) {
  std::uniform_real_distribution<double> when(static_cast<double>(first), static_cast<double>(last));
  for (int i = 0; i < fault.jumps; ++i) jumps_.push_back(static_cast<std::int64_t>(when(random_)));
  std::sort(jumps_.begin(), jumps_.end());
}

WheelSample FaultyWheels::apply(WheelSample recorded) {
  if (fault_.lag > 0.0) {
    history_.push(recorded.stamp, recorded.T_wheels_base);
    recorded.T_wheels_base =
        history_.at(recorded.stamp - fromSeconds(fault_.lag), std::chrono::hours(1)).value_or(recorded.T_wheels_base);
  }
  Pose2 motion = last_ ? between(*last_, recorded.T_wheels_base) : Pose2{};
  last_ = recorded.T_wheels_base;
  const double distance = std::hypot(motion.x, motion.y), turn = std::abs(motion.theta);
  if (fault_.swapped) motion = {motion.x, -motion.y, -motion.theta};
  if (fault_.backwards) motion = {-motion.x, -motion.y, -motion.theta};
  if (fault_.reverse_sign && motion.x < 0.0) motion.x = -motion.x;
  motion.x *= 1.0 + fault_.distance_scale;
  motion.x += fault_.noise * std::sqrt(distance) * normal_(random_);
  motion.theta += fault_.noise * std::sqrt(distance + turn) * normal_(random_);
  for (; next_jump_ < jumps_.size() && toMicroseconds(recorded.stamp) >= jumps_[next_jump_]; ++next_jump_) {
    motion = motion * Pose2{fault_.jump_translation * uniform_(random_), fault_.jump_translation * uniform_(random_),
                            fault_.jump_rotation * uniform_(random_)};
  }
  pose_ = pose_ * motion;
  recorded.T_wheels_base = pose_;
  return recorded;
}

}  // namespace slam
