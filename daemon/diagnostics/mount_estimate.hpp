// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>

#include "core/pose2.hpp"

namespace slam {

struct MountEstimateConfig {
  double least_turn = 0.1;      ///< [rad] of a pair of scans that tells the place
  double same_turn = 0.25;      ///< [1] of the turn, or of the least one, that wheels and gyro may be off
  double least_travel = 0.05;   ///< [m] of a pair that tells the yaw
  std::size_t least_pairs = 4;  ///< in each group: turns to each side, and ways, slow and fast ones
  std::size_t wanted = 12;      ///< turns to each side, to gather soon
  double outlier = 3.0;         ///< [1] of the median residual: a wrong match, or a slip
  double least_offset = 0.04;   ///< [m] less does little harm ...
  double least_yaw = 0.04;      ///< [rad] ... and so does less of a turn
  double sure = 4.0;            ///< [1] standard deviations
  double gain = 3.0;            ///< [1] standard deviations of how much better the pairs fit ...
  double left_over = 0.7;       ///< [1] ... of whose squared residuals so much may be left
  double alike = 0.5;           ///< [1] of the value, by which a group may differ
};

/// What to add to the lidar's mount.
struct MountCorrection {
  std::optional<Eigen::Vector2d> offset = {};  ///< [m] in base
  std::optional<double> yaw = {};              ///< [rad]
};

/// Where the lidar sits, by pairs of scans in which it and the wheels disagree about the motion: a lidar that is d away
/// from where it is said to be, and turned by yaw, moves by (R - I) d + R(-yaw) t where the wheels move by t [Censi
/// 2013, simultaneous calibration]. The wheels' scale is a third unknown, so that it is not taken for a mount.
///
/// Wheels that slip and sensors that lag look like a mount, too, but not the same in left and right turns, slow and
/// fast ones. So each of these groups must tell it by itself, and the pairs must fit much better with it than without.
/// And a gyro must confirm the turns: without one nobody knows that the wheels' are right.
///
/// No allocation.
class MountEstimate {
 public:
  explicit MountEstimate(const MountEstimateConfig& config = {}) : config_(config) {}

  /// @param scans, wheels motion of base between two scans, by each alone
  /// @param gyro_turn     [rad] the same by the gyro
  /// @param seconds       [s] between the two scans
  void add(const Pose2& scans, const Pose2& wheels, double gyro_turn, double seconds);

  /// Empty: not known, or there may as well be none to make.
  MountCorrection correction() const;
  /// Whether there are few turns to one side yet.
  bool wantsTurns() const;

 private:
  struct Pair {
    Pose2 scans, wheels;
    double speed;  // [m/s] or [rad/s], which of them its group is ordered by
  };
  struct Pairs {
    std::array<Pair, 48> last;
    std::size_t count = 0;
  };
  MountEstimateConfig config_;
  Pairs left_, right_, straight_;
};

}  // namespace slam
