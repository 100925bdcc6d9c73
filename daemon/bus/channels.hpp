// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Names of the LCM channels; the type of each is documented in lcmtypes/.
namespace slam::channel {

inline constexpr char kPose[] = "POSE";
inline constexpr char kLaser[] = "LASER";
inline constexpr char kSlamPose[] = "SLAM_POSE";
inline constexpr char kOdometry[] = "SLAM_ODOMETRY";
inline constexpr char kScan[] = "SLAM_SCAN";
inline constexpr char kWheels[] = "SLAM_WHEELS";
inline constexpr char kImu[] = "SLAM_IMU";
inline constexpr char kDepth[] = "SLAM_DEPTH";
inline constexpr char kMapMeta[] = "SLAM_MAP_META";
inline constexpr char kMapTile[] = "SLAM_MAP_TILE";
inline constexpr char kMapLidar[] = "SLAM_MAP_LIDAR";
inline constexpr char kMapDepth[] = "SLAM_MAP_DEPTH";
inline constexpr char kMapEdits[] = "SLAM_MAP_EDITS";
inline constexpr char kHealth[] = "SLAM_HEALTH";
inline constexpr char kProblems[] = "SLAM_PROBLEMS";
inline constexpr char kCommand[] = "SLAM_COMMAND";
inline constexpr char kDrive[] = "SLAM_DRIVE";
inline constexpr char kAck[] = "SLAM_ACK";
inline constexpr char kAnswer[] = "SLAM_ANSWER";  ///< problems_t: rows of SLAM_ACK's words, before it, with its utime
inline constexpr char kConfig[] = "SLAM_CONFIG";  ///< in field logs only

}  // namespace slam::channel
