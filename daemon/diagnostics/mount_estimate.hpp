// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>

#include "core/pose2.hpp"

namespace slam {

struct MountEstimateConfig {
  double least_turn = 0.1;      ///< [rad] of a pair of scans
  double same_turn = 0.25;      ///< [1] of it that the wheels may be off
  std::size_t least_turns = 8;  ///< to each side
  double least_offset = 0.08;   ///< [m] less does no harm, and slip makes as much
  double sure = 4.0;            ///< [1] deviations of the medians
};

/// Where the lidar sits, by turns in which it and the wheels disagree about the centre: a lidar that is d away from
/// where it is said to be moves by (R - I) d more than the wheels do [Censi 2013, simultaneous calibration]. The median
/// of left and of right turns, each for itself, lets wheels out of scale and a turned lidar fall out of their mean.
///
/// No allocation.
class MountEstimate {
 public:
  /// @param scans, wheels motion of base between two scans, by each alone
  void add(const Pose2& scans, const Pose2& wheels);

  /// [m] in base, from where the lidar is said to be to where it is; std::nullopt: not known, or it may as well be none
  std::optional<Eigen::Vector2d> offset() const;

 private:
  struct Turns {
    std::array<double, 48> x{}, y{};  // of the last ones
    std::size_t count = 0;
  };
  MountEstimateConfig config_;
  Turns left_, right_;
};

}  // namespace slam
