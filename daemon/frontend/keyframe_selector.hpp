// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>

#include "core/keyframe.hpp"
#include "estimation/odometry_monitor.hpp"
#include "frontend/front_end_config.hpp"
#include "frontend/local_map.hpp"
#include "frontend/preprocessor.hpp"
#include "matching/match_result.hpp"

namespace slam {

/// Says which scans become keyframes, and which only refresh the grid, and describes them: ids, session, and
/// how well the step from the keyframe before is known.
class KeyframeSelector {
 public:
  KeyframeSelector(const FrontEndConfig& config, const FrontEndStart& start);

  std::int32_t mapId() const { return map_id_; }
  /// Counts up when the robot is lost, or its pose given by a person.
  std::int32_t session() const { return session_; }
  /// @param heading_tolerance [rad] by which the heading may be off in the map before it
  void beginSession(KeyframeOrigin origin, double heading_tolerance);
  double headingTolerance() const { return keyframe_.heading_tolerance; }
  /// The step from the next keyframe on begins here.
  void begin(const Pose2& T_map_base) { drift_pose_ = T_map_base; }
  void transform(const Pose2& T_new_old);

  /// The robot moved on. @param match that told where to; nullptr: none did
  void addDrift(const Pose2& T_map_base, const MatchResult* match, const OdometryMonitor& monitor);

  /// @return the keyframe or refresh that a matched scan becomes; nullptr: none. Valid until the next call. A keyframe
  /// is added to the local map
  const Keyframe* select(const Cloud& cloud, const Pose2& T_map_base, const MatchResult& match, LocalMap& local_map);
  const Keyframe* keep(const Cloud& cloud, const Pose2& T_map_base, const MatchResult& match, LocalMap& local_map);

  void addTo(FrontEndCounters& counters) const;

 private:
  const Keyframe* refresh(const Cloud& cloud, const Pose2& T_map_base, const LocalMap& local_map);
  void describe(const Cloud& cloud, const Pose2& T_map_base);

  KeyframeConfig config_;
  DriftConfig drift_config_;
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
