// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <numbers>

#include "core/keyframe.hpp"
#include "estimation/odometry_monitor.hpp"
#include "frontend/front_end_state.hpp"
#include "frontend/lidar_model.hpp"
#include "frontend/local_map.hpp"
#include "frontend/preprocessor.hpp"
#include "matching/match_result.hpp"

namespace slam {

/// How the pose drifts from keyframe to keyframe while scans are matched; a random walk of strength q has standard
/// deviation q * sqrt(distance). Without matches, and along degenerate directions, the wheels' noise counts instead.
struct DriftConfig {
  double translation = 0.01;           ///< [m per sqrt(m)]
  double rotation_per_metre = 0.001;   ///< [rad per sqrt(m)]
  double rotation_per_radian = 0.003;  ///< [rad per sqrt(rad)]

  void visitSettings(auto& v) {
    v.expert("drift_translation", translation, "m per sqrt(m)", 1e-4, 1.0,
             "The position from matched scans has this standard deviation after one metre.");
    v.expert("drift_rotation_per_metre", rotation_per_metre, "rad per sqrt(m)", 1e-5, 1.0,
             "The heading from matched scans has this standard deviation after one metre.");
    v.expert("drift_rotation_per_radian", rotation_per_radian, "rad per sqrt(rad)", 1e-5, 1.0,
             "The heading from matched scans has this standard deviation after a turn of one radian.");
  }
};

/// When a scan is kept for reference and map.
struct KeyframeConfig {
  double translation = 0.20;  ///< [m] since the last keyframe
  double rotation = 0.17;     ///< [rad] since the last keyframe
  double known_ratio = 0.80;  ///< [1] a scan that shows this share of well-known surfels adds nothing: it is a refresh
  double refresh_period = 1.0;  ///< [s] between refreshes of a robot that stands still in a known place
  DriftConfig drift;

  void visitSettings(auto& v) {
    v.expert("translation", translation, "m", 0.01, 10.0,
             "A scan becomes a keyframe when the robot is this far from the last keyframe.");
    v.expert("rotation", rotation, "rad", 0.01, std::numbers::pi,
             "A scan becomes a keyframe when the robot has turned this far since the last keyframe.");
    v.expert("known_ratio", known_ratio, "1", 0.0, 1.0,
             "A scan with this share of points on well-known surfels adds no keyframe to the map.");
    v.expert("refresh_period", refresh_period, "s", 0.1, 3600.0,
             "A robot that stands still in a known place draws a scan into the occupancy grid this often.");
  }
};

/// Says which scans become keyframes, and which only refresh the grid, and describes them: ids, session, and
/// how well the step from the keyframe before is known.
class KeyframeSelector {
 public:
  /// @param localise_only the map is given: a session forgets the keyframes of the one before
  /// @param body_margin   [m] from scan to scan of what moves with the robot
  KeyframeSelector(const KeyframeConfig& config, const LidarModel& lidar, bool localise_only, double body_margin,
                   const FrontEndStart& start);

  std::int32_t mapId() const { return map_id_; }
  /// Counts up when the robot is lost, or its pose given by a person.
  std::int32_t session() const { return session_; }
  /// @param heading_tolerance [rad] by which the heading may be off in the map before it
  void beginSession(KeyframeOrigin origin, double heading_tolerance);
  double headingTolerance() const { return keyframe_.heading_tolerance; }
  /// The step from the next keyframe on begins here.
  void begin(const Pose2& T_map_base) { drift_pose_ = T_map_base; }
  void transform(const Pose2& T_new_old);

  /// The robot moved on. @param match that told where to; nullptr: none did @param by_gyro odometry turned by a gyro
  void addDrift(const Pose2& T_map_base, const MatchResult* match, const OdometryMonitor& monitor, bool by_gyro);

  /// @return the keyframe or refresh that a matched scan becomes; nullptr: none. Valid until the next call. A keyframe
  /// is added to the local map
  /// @param sensitivity of the pose, in map
  const Keyframe* select(const Cloud& cloud, const Pose2& T_map_base, const MatchResult& match,
                         const Sensitivity& sensitivity, LocalMap& local_map);
  const Keyframe* keep(const Cloud& cloud, const Pose2& T_map_base, const MatchResult& match,
                       const Sensitivity& sensitivity, LocalMap& local_map);

  void addTo(FrontEndCounters& counters) const;

 private:
  const Keyframe* refresh(const Cloud& cloud, const Pose2& T_map_base, const LocalMap& local_map);
  void describe(const Cloud& cloud, const Pose2& T_map_base);

  KeyframeConfig config_;
  Pose2 T_base_lidar_;
  bool upside_down_;
  std::int32_t map_id_;
  int first_keyframe_;
  bool localise_only_;
  Keyframe keyframe_;
  int next_keyframe_;
  std::int32_t session_ = 0;
  KeyframeOrigin origin_;  // of the next keyframe
  Pose2 last_refresh_;
  Timestamp last_refresh_stamp_;
  Pose2 drift_pose_;
  Eigen::Matrix3d drift_ = Eigen::Matrix3d::Zero();   // in map, since the last keyframe
  Eigen::Matrix3d unseen_ = Eigen::Matrix3d::Zero();  // in map: the part of it that no match told
  std::uint32_t keyframes_ = 0;
};

}  // namespace slam
