// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <random>

#include "core/pose2.hpp"
#include "tools/sim/world/world.hpp"

namespace slam::sim {

/// An RPLidar A1 as it measures.
struct LidarErrors {
  double range_noise = 0.004;            ///< [m] standard deviation near by ...
  double range_noise_per_metre = 0.003;  ///< [m/m] ... and growing with the range
  double angle_jitter = 0.0017;          ///< [rad] standard deviation of a beam's direction
  double dropout = 0.01;                 ///< [1] share of beams without return
  double range_max = 12.0;               ///< [m]
};

class LidarModel {
 public:
  static constexpr double kHeight = 0.18;                      ///< [m] above the floor
  static constexpr double kRangeMin = 0.15, kRangeMax = 12.0;  ///< [m]
  static constexpr double kTurnRate = 5.5;                     ///< [1/s]
  static constexpr Pose2 kExtrinsics{0.06, 0.0, 0.0};          ///< T_base_lidar

  LidarModel(const World& world, const LidarErrors& errors, std::uint64_t seed)
      : world_(world), errors_(errors), random_(seed ^ 0x9E3779B97F4A7C15ULL) {}

  /// @param bearing [rad] counter-clockwise in the lidar's frame
  /// @return range [m], 0 without return
  double measure(const Pose2& T_world_base, double bearing);
  /// The same where the range without error [m], infinity without return, is `sight` of the beam's true bearing.
  double measure(double bearing, const std::function<double(double bearing)>& sight);
  /// The range without any error; infinity where nothing is in reach.
  double trueRange(const Pose2& T_world_base, double bearing, const Pose2& T_base_lidar = kExtrinsics) const;

 private:
  const World& world_;
  LidarErrors errors_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_{0.0, 1.0};
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
};

}  // namespace slam::sim
