// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/keyframe.hpp"
#include "core/pose_covariance.hpp"
#include "frontend/map_correction.hpp"
#include "matching/reference.hpp"
#include "matching/scan_points.hpp"

namespace slam {

/// The keyframe nearest to a pose, and the pose relative to it.
struct AnchoredPose {
  int keyframe = -1;  ///< -1: there is none yet, and the pose is that in map
  Pose2 T_keyframe_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< what is not known of the map there: of the pose in map, in
                                                         ///< base's axes [m, m, rad], if the keyframe's were exact
};

/// What scans are matched against: the keyframes around the robot. It holds what the back end's newest correction put
/// in, and the keyframes made since, which that correction does not know.
///
/// After construction no allocation.
class LocalMap {
 public:
  /// @param localise_only the map is given: scans do not extend it
  LocalMap(const ReferenceConfig& reference, const Pose2& T_base_lidar, bool localise_only = false);

  /// Nothing was added since the beginning or clear().
  bool empty() const { return !newest_; }
  const Reference& reference() const { return reference_; }
  /// By id.
  std::span<const ReferenceKeyframe> keyframes() const { return keyframes_; }
  AnchoredPose anchor(const Pose2& T_map_base) const;
  /// Looks among all keyframes for the one nearest to the robot. @param robot [m] in map
  void follow(const Eigen::Vector2d& robot);
  /// As anchor(), of the keyframe that follow() has found: without a search.
  Eigen::Matrix3d covarianceAt(const Pose2& T_map_base) const {
    return carried(followed_.covariance, between(followed_.T_map_base, T_map_base));
  }
  /// Whether keyframes are added: not to a given map that the robot was found in.
  bool extends() const { return extends_; }

  /// Pose of the newest keyframe. @pre !empty()
  const Pose2& newest() const { return *newest_; }

  void takeMemory() { reference_.takeMemory(); }
  void add(const Keyframe& keyframe, const ScanPoints& points);
  /// Moves the middle of the area held. @param robot [m] in map
  void recentre(const Eigen::Vector2d& robot) { reference_.recentre(robot); }
  /// Begins anew. @param robot [m] in map
  void clear(const Eigen::Vector2d& robot);

  /// Goes on with what a correction holds, and leaves what was held in it. Keyframes newer than the correction stay,
  /// and move as the newest one does that it knows.
  /// @param robot [m] in map
  /// @return how the map moved there: as the keyframe nearest to it, or to where a lost robot was found
  Pose2 apply(MapCorrection& correction, const Eigen::Vector2d& robot);

 private:
  struct KeptScan {
    int id = -1;
    std::vector<Keyframe::Point> points;
  };
  const ReferenceKeyframe* nearest(const Eigen::Vector2d& p_map) const;
  KeptScan& kept(int id) { return kept_[static_cast<std::size_t>(id) % kept_.size()]; }

  Pose2 T_base_lidar_;
  bool localise_only_;
  Reference reference_;
  std::vector<ReferenceKeyframe> keyframes_;              // by id
  std::array<KeptScan, MapCorrection::kMostAhead> kept_;  // newest keyframes, which a correction may not know yet
  std::optional<Pose2> newest_;
  ReferenceKeyframe followed_;  // nearest to the robot; of an empty map one whose pose is exact
  ScanPoints scratch_;
  bool extends_ = true;
};

}  // namespace slam
