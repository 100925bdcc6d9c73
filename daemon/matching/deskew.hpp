// SPDX-License-Identifier: BSD-3-Clause
#pragma once
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

/// Undoes the motion within a scan: each return is taken to base at the scan's stamp by the pose at its own time.
///
/// @param scan         beams in acquisition order, any time offsets
/// @param limits       other ranges are no returns
/// @param stamp        the scan's stamp in the history's time
/// @param mounting     extrinsics
/// @param history      poses of base over the scan, in any frame; empty: the robot is taken to stand still
/// @param points       out: the returns, without normals; its capacity is reused
void deskew(const LaserScan& scan, const RangeLimits& limits, Timestamp stamp, const LidarMounting& mounting,
            const PoseHistory& history, ScanPoints& points);

}  // namespace slam
