// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/pose2.hpp"
#include "core/pose_history.hpp"
#include "core/scan.hpp"
#include "matching/scan_points.hpp"

namespace slam {

/// How the lidar sits on the base.
struct LidarMounting {
  Pose2 T_base_lidar;
  bool upside_down = false;  ///< its bearings grow clockwise, seen from above

  LidarMounting(const Pose2& T_base_lidar_, bool upside_down_ = false)
      : T_base_lidar(T_base_lidar_), upside_down(upside_down_) {}
};

/// Cosine and sine of beams' bearings. Most lidars measure at the same bearings turn by turn: what is asked of a beam
/// again is not computed again. All memory is taken at construction.
class BearingTable {
 public:
  BearingTable() : directions_(LaserScan::kCapacity) {}

  /// @param beam index in its scan @param bearing [rad] of it
  /// @return its direction, unit
  const Eigen::Vector2d& direction(std::size_t beam, float bearing) {
    Entry& entry = directions_[beam];
    if (entry.bearing != bearing) entry = {bearing, computed(bearing)};
    return entry.direction;
  }
  static Eigen::Vector2d computed(float bearing) {
    const auto angle = static_cast<double>(bearing);
    return {std::cos(angle), std::sin(angle)};
  }

 private:
  struct Entry {
    float bearing = 0.0F;                 // [rad]
    Eigen::Vector2d direction{1.0, 0.0};  // unit
  };
  std::vector<Entry> directions_;  // by index
};

/// Undoes the motion within a scan: each return is taken to base at the scan's stamp by the pose at its own time.
///
/// @param scan         beams in acquisition order, any time offsets
/// @param limits       other ranges are no returns
/// @param stamp        the scan's stamp in the history's time
/// @param mounting     extrinsics
/// @param history      poses of base over the scan, in any frame; empty: the robot is taken to stand still
/// @param points       out: the returns, without normals; its capacity is reused
/// @param bearings     of the lidar's last scans; nullptr: computes all
void deskew(const LaserScan& scan, const RangeLimits& limits, Timestamp stamp, const LidarMounting& mounting,
            const PoseHistory& history, ScanPoints& points, BearingTable* bearings = nullptr);

}  // namespace slam
