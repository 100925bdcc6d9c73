// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/wheel_scale.hpp"

#include <cmath>

namespace slam {
void WheelScale::add(const Pose2& wheels, const Pose2& scans, double variance, double excess) {
  const double path_length = std::hypot(scans.x, scans.y);
  if (!(path_length > 0.0) || !(excess * variance > 0.0)) return;
  variance_ += square(config_.noise) * path_length;
  const double along = (wheels.x * scans.x + wheels.y * scans.y) / path_length;
  const double innovation = along - scale_ * path_length, prior = path_length * variance_ * path_length;
  if (!(square(innovation) <= square(config_.gate) * (prior + variance))) return;
  const double K = variance_ * path_length / (prior + excess * variance);
  scale_ += K * innovation;
  variance_ *= 1.0 - K * path_length;
}

double WheelScale::value() const {
  const bool scale = scale_ < config_.largest_factor && scale_ * config_.largest_factor > 1.0;
  return scale && std::abs(scale_ - 1.0) > config_.significance * sigma() ? scale_ : 1.0;
}

double WheelScale::sigma() const { return std::sqrt(variance_); }

}  // namespace slam
