// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "core/estimates.hpp"
#include "core/pose_covariance.hpp"
#include "frontend/front_end_state.hpp"
#include "matching/match_result.hpp"

namespace slam {

/// When a pose is degraded, lost, or to be acted upon.
struct TrackingConfig {
  int max_failures = 8;              ///< scans in a row without a match, and `degraded_after`: then something is done
  double degraded_after = 1.0;       ///< [s] without a matched scan
  double lost_after = 1.0;           ///< [s] without a sample of wheels or gyro, or a matched scan: a pose is a guess
  double lost_position_sigma = 1.0;  ///< [m] a position this uncertain is not valid

  void visitSettings(auto& v) {
    v.expert("degraded_after", degraded_after, "s", 0.1, 60.0,
             "The pose is degraded after this time without a matched scan.");
    v.expert("lost_position_sigma", lost_position_sigma, "m", 0.05, 100.0,
             "A position with a larger standard deviation than this is not valid.");
  }
};

/// How well the robot's place is known, and what the last scans told of it.
class TrackingState {
 public:
  /// @param localise_only the map is given, and knows no outside
  TrackingState(const TrackingConfig& config, bool localise_only, bool in_known_map);

  /// The first scan of a map or session, which lies where the robot is by definition.
  void begin(Timestamp stamp, const Pose2& T_map_base, const Pose2& T_odom_base);
  /// A match was fused.
  void follow(const MatchResult& match, Timestamp stamp, const Pose2& T_map_base, const Pose2& T_odom_base);
  /// No match was fused. @param informative the scan has enough points @param may_act something can be done about it
  /// @return whether that has lasted so long that something must be done
  bool fail(const MatchResult& match, Timestamp stamp, bool informative, bool may_act);

  /// Whether a robot that scans match no longer can be anywhere: in a given map there is nothing else to know, and of a
  /// session whose place is not known yet nothing is worth going on with.
  /// @param covariance of the pose [m, m, rad]
  bool lost(const Eigen::Matrix3d& covariance) const;
  /// Whether the place is known too badly to go on from it. @param covariance as for lost()
  bool unplaced(const Eigen::Matrix3d& covariance) const;
  /// What is known of the robot's place in the map.
  enum class Place : std::uint8_t {
    kNever,    ///< not found yet
    kNoMore,   ///< not found again
    kAssumed,  ///< where it was, if the map is the right one
    kKnown
  };
  /// @param place kNoMore where the robot has to be found
  void beginSession(Place place);
  /// The robot was found in the map, or is not where it was assumed, or a person said.
  void place() { place_ = Place::kKnown; }
  void refute() { place_ = Place::kNoMore; }
  void transform(const Pose2& T_new_old) {
    last_pose_ = T_new_old * last_pose_;
    tension_ = rotated(tension_, T_new_old.theta);
  }

  /// @param last_source stamp of the newest sample of any sensor that tells the motion
  /// @param covariance of the filter [m, m, rad] @param contradicted matched scans and odometry tell different
  /// ways
  LocalisationState state(Timestamp stamp, Timestamp last_source, const Eigen::Matrix3d& covariance,
                          bool contradicted = false) const;
  /// No sensor tells the motion any more.
  bool silent(Timestamp stamp, Timestamp last_source) const {
    return toSeconds(stamp - last_source) > config_.lost_after;
  }
  /// Whether any scan was placed yet.
  bool begun() const { return last_match_.has_value(); }
  bool placed() const { return place_ >= Place::kAssumed; }
  /// It may be in another map.
  bool assumed() const { return place_ == Place::kAssumed; }
  /// Whether no scan was fused for so long that the odometry leads.
  bool unmatched(Timestamp stamp) const;

  int failures() const { return failures_; }
  double overlap() const { return overlap_; }             ///< [1] of the last match
  double fusedOverlap() const { return fused_overlap_; }  ///< [1] of the last one that was fused
  /// Of the last one that was fused, by how its parts contradict each other, in map [m, m, rad].
  const Eigen::Matrix3d& tension() const { return tension_; }
  const Pose2& lastPose() const { return last_pose_; }          ///< at the last matched scan
  const Pose2& lastMotion() const { return last_motion_; }      ///< to it from the one before
  const Pose2& lastOdometry() const { return last_odometry_; }  ///< in odom, at the last matched scan

  void addTo(FrontEndCounters& counters) const;

 private:
  TrackingConfig config_;
  bool localise_only_;
  std::optional<Timestamp> last_match_;
  Pose2 last_pose_, last_motion_, last_odometry_;
  double overlap_ = 0.0, fused_overlap_ = 0.0;
  Eigen::Matrix3d tension_ = Eigen::Matrix3d::Zero();
  int failures_ = 0;
  Place place_;
  std::uint32_t matched_ = 0, partly_observable_ = 0, unmatched_ = 0, gated_ = 0;
};

}  // namespace slam
