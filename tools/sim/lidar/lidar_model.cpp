// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/lidar_model.hpp"

#include <cmath>
#include <limits>

namespace slam::sim {

double LidarModel::trueRange(const Pose2& T_world_base, double bearing) const {
  const Pose2 lidar = T_world_base * kExtrinsics;
  const double direction = lidar.theta + bearing;
  return world_.castRay({lidar.x, lidar.y, kHeight}, {std::cos(direction), std::sin(direction), 0.0}, kRangeMax)
      .value_or(std::numeric_limits<double>::infinity());
}

double LidarModel::measure(const Pose2& T_world_base, double bearing) {
  const double jitter = errors_.angle_jitter * normal_(random_), noise = normal_(random_), drop = uniform_(random_);
  const double truth = trueRange(T_world_base, bearing + jitter);
  if (!std::isfinite(truth) || drop < errors_.dropout) return 0.0;
  const double range = truth + (errors_.range_noise + errors_.range_noise_per_metre * truth) * noise;
  return range >= kRangeMin && range <= kRangeMax ? range : 0.0;
}

}  // namespace slam::sim
