// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/lidar_model.hpp"

#include <cmath>
#include <limits>

namespace slam::sim {

double LidarModel::trueRange(const Pose2& T_world_base, double bearing, const Pose2& T_base_lidar) const {
  const Pose2 lidar = T_world_base * T_base_lidar;
  const double direction = lidar.theta + bearing;
  return world_.castRay({lidar.x, lidar.y, kHeight}, {std::cos(direction), std::sin(direction), 0.0}, errors_.range_max)
      .value_or(std::numeric_limits<double>::infinity());
}

double LidarModel::measure(const Pose2& T_world_base, double bearing) {
  return measure(bearing, [&](double true_bearing) { return trueRange(T_world_base, true_bearing); });
}

double LidarModel::measure(double bearing, const std::function<double(double bearing)>& sight) {
  const double jitter = errors_.angle_jitter * normal_(random_), noise = normal_(random_), drop = uniform_(random_);
  const double truth = sight(bearing + jitter);
  if (!std::isfinite(truth) || drop < errors_.dropout) return 0.0;
  const double range = truth + (errors_.range_noise + errors_.range_noise_per_metre * truth) * noise;
  return range >= kRangeMin && range <= errors_.range_max ? range : 0.0;
}

}  // namespace slam::sim
