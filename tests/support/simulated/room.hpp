// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/pose2.hpp"
#include "core/scan.hpp"

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
    std::normal_distribution<double> noise(0.0, 1.0);
    LaserScan scan;
    scan.range_min = 0.05F;
    scan.range_max = static_cast<float>(reach);
    for (int i = 0; i < beams; ++i) {
      const double bearing = wrapAngle(2.0 * std::numbers::pi * i / beams);
      const double truth = range(pose, bearing), measured = truth + range_sigma * noise(random);
      scan.push({.range = truth < reach ? static_cast<float>(measured) : 0.0F, .bearing = static_cast<float>(bearing)});
    }
    return scan;
  }
};

}  // namespace slam::test
