// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <numbers>
#include <vector>

#include "core/pose2.hpp"
#include "core/pose_covariance.hpp"
#include "core/scan.hpp"
#include "matching/deskew.hpp"

namespace slam {

/// Bearings as a scan's beams have them, counter-clockwise from one to the other [deg].
struct BearingRange {
  double from = 0.0, to = 0.0;  ///< to >= from
  friend bool operator==(const BearingRange&, const BearingRange&) = default;
};

/// Standard deviations of what a lidar's ranges and bearings are off by in each scan alike, as its data sheet has them.
struct SystematicPrior {
  double range_bias = 0.015;     ///< [m] an RPLidar's; triangulation and phase shift of grey walls make 1 to 3 cm
  double bearing_scale = 0.002;  ///< [1] a beam of a full turn in 500, by the encoder's or the driver's count
  double mount_yaw = 0.0087;     ///< [rad] half a degree: what a level of 10 cm on the robot's side tells
  double mount_offset = 0.01;    ///< [m] along each axis, by a tape from the wheels' axle

  /// Of (x, y, yaw) of the mount [m, m, rad].
  Eigen::Matrix3d mountCovariance() const {
    return Eigen::Vector3d(mount_offset * mount_offset, mount_offset * mount_offset, mount_yaw * mount_yaw)
        .asDiagonal();
  }
  Eigen::Matrix<double, kSystematic, kSystematic> covariance() const {
    return Eigen::Vector2d(range_bias * range_bias, bearing_scale * bearing_scale).asDiagonal();
  }

  void visitSettings(auto& v) {
    v.expert("range_bias_sigma", range_bias, "m", 0.0, 1.0,
             "All ranges of the lidar are too long or too short by one length with this standard deviation.");
    v.expert("bearing_scale_sigma", bearing_scale, "1", 0.0, 1.0,
             "All bearings of the lidar are too wide or too narrow by one share with this standard deviation.");
    v.expert("mount_yaw_sigma", mount_yaw, "rad", 1e-4, 3.2, "The lidar's yaw is known with this standard deviation.");
    v.expert("mount_offset_sigma", mount_offset, "m", 1e-4, 5.0,
             "The lidar's x and y are known with this standard deviation.");
  }
};

/// Extrinsics of the lidar and what its readings are worth.
struct LidarModel {
  Pose2 T_base_lidar;
  bool upside_down = false;    ///< its bearings grow clockwise, seen from above
  double range_min = 0.15;     ///< [m] shorter returns are not obstacles
  double range_max = 12.0;     ///< [m] longer returns are not trusted
  double range_sigma = 0.015;  ///< [m] standard deviation of one range
  SystematicPrior systematic;
  double time_offset = 0.0;        ///< [s] added to the lidar's stamps
  std::vector<BearingRange> mask;  ///< where the robot itself is seen

  LidarMounting mounting() const { return {T_base_lidar, upside_down}; }
  /// Where the scan knows better it says so.
  RangeLimits limitsFor(const LaserScan& scan) const {
    return {std::max(scan.range_min, static_cast<float>(range_min)),
            std::min(scan.range_max, static_cast<float>(range_max))};
  }

  void visitSettings(auto& v) {
    v.robot("x", T_base_lidar.x, "m", -5.0, 5.0, "The lidar is mounted this far ahead of the base's turning centre.",
            "Measure it on each robot, or use slam-calibrate.");
    v.robot("y", T_base_lidar.y, "m", -5.0, 5.0, "The lidar is mounted this far left of the base's turning centre.",
            "Measure it on each robot, or use slam-calibrate.");
    v.robot("yaw", T_base_lidar.theta, "rad", -std::numbers::pi, std::numbers::pi,
            "The lidar's zero direction is turned by this angle to the left of the robot's forward.",
            "Measure it on each robot, or use slam-calibrate.");
    v.robot("upside_down", upside_down,
            "The lidar is mounted top down, so that its bearings grow clockwise when they are seen from above.",
            "Set true when the lidar hangs from a plate.");
    v.site("range_min", range_min, "m", 0.0, 10.0, "Lidar returns that are nearer than this are ignored.",
           "Raise it when the lidar sees parts of the robot.");
    v.site("range_max", range_max, "m", 0.5, 200.0, "Lidar returns that are farther than this are ignored.",
           "Set it to the range up to which the lidar's data sheet gives an accuracy.");
    v.expert("range_sigma", range_sigma, "m", 0.0005, 0.5, "One range of the lidar has this standard deviation.");
    systematic.visitSettings(v);
    v.site("mask", mask,
           "Beams at these bearings are left out: pairs of a first and a last angle, counter-clockwise from the "
           "lidar's zero direction.",
           "Set it where the lidar sees parts of the robot that slamd does not find by itself.");
    v.expert("time_offset", time_offset, "s", -1.0, 1.0, "This time is added to the stamps of the lidar's scans.");
  }
};

}  // namespace slam
