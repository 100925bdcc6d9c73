// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "frontend/dynamic_object_gate.hpp"
#include "frontend/local_map.hpp"
#include "frontend/preprocessor.hpp"
#include "frontend/registration.hpp"
#include "frontend/tracking_state.hpp"
#include "matching/correlative.hpp"
#include "matching/range_image.hpp"

namespace slam {

/// Which matches are believed.
struct ValidatorConfig {
  double trusted_overlap = 0.70;       ///< [1] of a find that overrules the filter
  double same_overlap = 0.02;          ///< [1] a match that lost no more since the last one fits as before
  double gyro_error = 0.1;             ///< [rad] of a turn by the gyro, beside three of its standard deviations
  double much_worse = 0.12;            ///< [1] overlap lost by a find: it is another place
  double free_space_violation = 0.12;  ///< [1] of the walls in sight; of a right find at most 0.10
  double walls_in_the_open = 0.4;  ///< [1] of a scan's points on walls that stand where earlier scans saw through ...
  double in_the_open_for = 3.0;    ///< [s] ... so long: the robot was carried away

  void visitSettings(auto& v) {
    v.expert("trusted_overlap", trusted_overlap, "1", 0.0, 1.0,
             "A found match overrules the filter if this share of its points agrees with the local map.");
  }
};

/// Says which matches can be believed, and takes out of them what something that moves has made of them.
class MatchValidator {
 public:
  /// @param reach   how far a robot gets from scan to scan
  /// @param p_lidar [m] in base
  MatchValidator(const ValidatorConfig& config, const DynamicObjectGateConfig& gate, const SearchWindow& reach,
                 const Eigen::Vector2d& p_lidar);

  /// Takes out of a match what something that moves may have made of it: there the wheels tell the way.
  void removeDynamicBias(MatchResult& match, const Cloud& cloud, const LocalMap& local_map, const Prediction& predicted,
                         const WheelMonitor& wheels);
  /// Whether a match from a prediction can be believed. Once the way is lost, what fits there is a find, too; and where
  /// no scan told anything for long though the robot stood: its lidar may have been covered while it was carried.
  bool acceptTracking(const MatchResult& match, const Cloud& cloud, const LocalMap& local_map, const Ekf& predicted,
                      const TrackingState& tracking);
  /// Whether a match can be believed wherever the robot was thought to be. Among many places one fits by half: a find
  /// needs more agreement than a prediction does. A room has corners that look like one another: in the right one the
  /// scan sees through no walls, and fits about as well as the last one did. Where a robot gets from scan to scan it
  /// may fit worse: it has turned to what it had not seen. A gyro measures how far it has turned.
  bool acceptSearch(const MatchResult& match, const Cloud& cloud, const LocalMap& local_map, const Ekf& predicted,
                    const TrackingState& tracking);
  /// Whether a scan that matches no longer was not taken there at all: it would see through what stands there.
  bool kidnapped(const Pose2& T_map_base, const Cloud& cloud, const LocalMap& local_map) {
    return seesThroughWalls(T_map_base, cloud, local_map, 0.0);
  }

  /// Whether the robot was carried away although its scans match: for seconds many of their walls have stood where the
  /// scans before saw through. A wall that it was carried along fits as well as before, and tells nothing of that. Who
  /// walks beside it shows hardly a line, and soon stands elsewhere.
  bool wallsInTheOpen(const Cloud& cloud);
  /// A session begins.
  void begin() { in_the_open_since_.reset(); }

  /// By how much a heading may be off [rad] that a gyro has told; pi: none has.
  double headingTolerance(const Ekf& predicted) const;

  /// Matches that something moving pulled.
  std::uint32_t held() const { return held_; }

 private:
  double support(const MatchResult& match, const Pose2& guess, const Cloud& cloud, const LocalMap& local_map);
  bool seesThroughWalls(const Pose2& T_map_base, const Cloud& cloud, const LocalMap& local_map, double known);
  bool contradictsGyro(const MatchResult& match, const Ekf& predicted) const;
  bool isNear(const Pose2& T_map_base, const Pose2& last_pose) const;

  Eigen::Vector2d lidar_;  // [m] in base
  ValidatorConfig config_;
  SearchWindow reach_;
  DynamicObjectGate dynamic_objects_;
  RangeImage image_;
  std::uint32_t held_ = 0;
  std::optional<Timestamp> in_the_open_since_;
};

}  // namespace slam
