// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <numbers>
#include <random>

#include "core/pose2.hpp"
#include "core/scan.hpp"

namespace slam::test {

/// How a lidar measures.
struct SimulatedLidar {
  int beams = 360;
  double reach = 12.0, range_sigma = 0.01;            ///< [m]
  double first = 0.0, view = 2.0 * std::numbers::pi;  ///< [rad] bearing of the first beam; what all of them cover
  double sweep = 0.0;                                 ///< [s] time of a revolution; 0: all beams are measured at once

  /// A revolution of a robot in motion, which ends at a pose. @param world its range() is infinite: no wall
  template <typename World>
  LaserScan scan(const World& world, const Pose2& pose, std::mt19937& random,
                 const Eigen::Vector3d& twist = {0, 0, 0}) const {
    std::normal_distribution<double> noise(0.0, range_sigma);
    LaserScan scan;
    scan.range_min = 0.05F;
    scan.range_max = static_cast<float>(reach);
    for (int i = 0; i < beams; ++i) {
      const double offset = sweep * i / beams, bearing = wrapAngle(first + view * i / beams);
      const double truth = world.range(sweep > 0.0 ? pose * exp((offset - sweep) * twist) : pose, bearing);
      const double measured = std::isfinite(truth) ? truth + noise(random) : truth;
      scan.push({.range = truth < reach ? static_cast<float>(measured) : 0.0F,
                 .bearing = static_cast<float>(bearing),
                 .time_offset = static_cast<float>(offset)});
    }
    return scan;
  }
};

}  // namespace slam::test
