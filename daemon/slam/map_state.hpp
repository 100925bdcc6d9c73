// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "core/pose2.hpp"
#include "mapping/occupancy_grid.hpp"
#include "posegraph/keyframe_graph.hpp"

namespace slam {

/// All that is needed to go on in a map another day.
struct MapState {
  KeyframeGraph keyframes;
  OccupancyGrid grid;
  Pose2 T_map_base;           ///< where the robot was last
  double gyro_bias = 0.0;     ///< [rad/s]
  Pose2 T_base_lidar;         ///< extrinsics that the keyframes were taken with
  double range_max = 0.0;     ///< [m] of the lidar
  std::int64_t utime = 0;     ///< [us] of the last keyframe
  bool picture_only = false;  ///< made from a picture of a map: it serves localisation alone
};

}  // namespace slam
