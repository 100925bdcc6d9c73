// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "support/simulated/lidar.hpp"

namespace slam::test {

/// A rectangle of length x width [m] about the origin, scanned all around; beyond `reach` there is no return.
struct Room {
  double length = 6.0, width = 4.0, reach = 12.0;
  double range_sigma = 0.0;  ///< [m]
  int beams = 360;

  double range(const Pose2& pose, double bearing) const {
    const double c = std::cos(pose.theta + bearing), s = std::sin(pose.theta + bearing);
    const auto wall = [](double position, double direction, double half) {
      if (std::abs(direction) < 1e-12) return std::numeric_limits<double>::infinity();
      return (std::copysign(half, direction) - position) / direction;
    };
    return std::min(wall(pose.x, c, length / 2), wall(pose.y, s, width / 2));
  }

  LaserScan scan(const Pose2& pose, std::mt19937& random) const {
    const SimulatedLidar lidar{.beams = beams, .reach = reach, .range_sigma = range_sigma};
    return lidar.scan(*this, pose, random);
  }
};

}  // namespace slam::test
