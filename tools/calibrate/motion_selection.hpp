// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "tools/calibrate/sensor_log.hpp"
#include "tools/calibrate/wheel_model.hpp"

namespace slam {

/// When a motion is long enough to tell more than the noise of two matches, and short enough to know its wheels' path.
struct MotionConfig {
  double translation = 0.30;     ///< [m] ends a motion ...
  double rotation = 0.35;        ///< [rad] ... and so does this
  double max_time = 5.0;         ///< [s] a motion that takes longer is dropped
  double max_scan_gap = 1.0;     ///< [s] between two matched scans
  double max_wheel_gap = 1.0;    ///< [s] between two readings of the wheels
  double max_wheel_speed = 3.0;  ///< [m/s] a faster wheel is a counter that began anew
};

/// Cuts a log into motions that follow each other, from matched scan to matched scan. The wheels' angles at a scan's
/// stamp are interpolated between the two readings around it. The wheels decide where a motion ends: a lidar that ended
/// its own would do so where its errors add to the motion, which makes the radii come out too small.
/// @param configured  as the log was matched with: its T_base_lidar turns the matches' T_map_base to T_map_lidar
std::vector<LidarMotion> selectMotions(const SensorLog& log, const RobotGeometry& configured,
                                       const MotionConfig& config = {});

}  // namespace slam
