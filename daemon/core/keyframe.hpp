// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "core/pose2.hpp"
#include "core/pose_covariance.hpp"
#include "core/scan.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// How a keyframe hangs together with the one before it.
enum class KeyframeOrigin : std::uint8_t {
  kContinued,  ///< by the motion between them
  kLost,       ///< not at all: a new session begins, whose poses are relative to its own beginning
  kGiven,      ///< a new session begins, whose place a person gave
  kAssumed,    ///< a new session begins where the one before was, or in another map: a lift may have come between
};

/// A scan handed to the map: deskewed returns and where they were taken. Fixed capacity, so that it crosses queues
/// without allocation.
struct Keyframe {
  struct Point {
    static constexpr double kAngle = 1e-4;  ///< [rad] unit of the two fields below
    static constexpr std::int16_t kNoNormal = INT16_MIN;
    static constexpr std::uint16_t kGrazing = 1;
    float x, y;                       ///< [m] in base
    std::int16_t normal = kNoNormal;  ///< direction of the wall's normal in base; kNoNormal: on no line
    std::uint16_t normal_sigma = 0;   ///< standard deviation of that direction; on no line: kGrazing where the spot
                                      ///< may move along a wall as the robot does, else 0
  };

  std::int32_t map_id = 0;   ///< map that it belongs to
  std::int32_t id = 0;       ///< counts from 0 in its map; of a refresh: the keyframe nearest to it
  std::int32_t session = 0;  ///< counts the times that the place in the map was lost or given
  KeyframeOrigin origin = KeyframeOrigin::kContinued;
  bool refresh = false;   ///< shows nothing new: it refreshes the grid and is then forgotten, so that a known place
                          ///< costs no memory however long the robot stays
  Timestamp stamp;        ///< of the middle of the turn, as the points are
  Pose2 T_map_base;       ///< as the front end knew it then
  Pose2 T_previous_base;  ///< relative to the keyframe before it; of a refresh: relative to keyframe `id`
  Pose2 T_base_lidar;
  int observable = 3;  ///< directions in which a match said where it is; 0: the filter's prediction alone
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();   ///< columns: unit directions of (x, y, theta) in map, the
                                                              ///< observable ones first
  Eigen::Matrix3d step_covariance = Eigen::Matrix3d::Zero();  ///< of this pose relative to the keyframe before it
                                                              ///< (x, y, theta) in that one's base [m, m, rad]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();       ///< of T_map_base in map, in base's axes [m, m, rad]
  Sensitivity sensitivity = Sensitivity::Zero();              ///< of T_map_base, in base's axes
  /// [rad] by which the session's heading may be off in the map that was lost, by the gyro; pi: nothing is known
  double heading_tolerance = std::numbers::pi;
  /// What moves with the robot, as far as is known by now: counterclockwise about T_base_lidar. The points have none of
  /// it, those of older keyframes may.
  BodyShape body;
  double body_margin = 0.0;  ///< [m] by which a point of it may lie beside it
  int size = 0;
  std::array<Point, LaserScan::kCapacity> storage;

  std::span<const Point> points() const { return {storage.data(), static_cast<std::size_t>(size)}; }
};

/// What is stored of a keyframe's scan: no more than it needs.
struct StoredScan {
  Timestamp stamp;  ///< of the middle of the turn
  Pose2 T_base_lidar;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of its pose when it was made, in base's axes [m, m, rad];
                                                         ///< of a stored map zero: that map is what poses refer to
  Sensitivity sensitivity = Sensitivity::Zero();         ///< of its pose, in base's axes; of a stored map zero, too
  std::vector<Keyframe::Point> points;                   ///< [m] in base, in acquisition order
  /// [m] in base. Of a picture, whose points are the borders of its walls, seen from nowhere: its free cells, and those
  /// within the walls.
  std::vector<Eigen::Vector2f> free, solid;

  StoredScan() = default;
  explicit StoredScan(const Keyframe& keyframe)
      : stamp(keyframe.stamp),
        T_base_lidar(keyframe.T_base_lidar),
        covariance(keyframe.covariance),
        sensitivity(keyframe.sensitivity),
        points(keyframe.points().begin(), keyframe.points().end()) {}
};

}  // namespace slam
