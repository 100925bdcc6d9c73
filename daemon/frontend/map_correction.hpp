// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/pose2.hpp"
#include "core/pose_covariance.hpp"
#include "matching/reference.hpp"

namespace slam {

/// A keyframe as the reference holds it.
struct ReferenceKeyframe {
  int id = 0;
  Pose2 T_map_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of it in map, in base's axes [m, m, rad]
  Sensitivity sensitivity = Sensitivity::Zero();         ///< of it in map, in base's axes
};

/// What the back end gives the FrontEnd: the part of the map around the robot, built anew. Handed over whole and
/// handed back with the old one inside, so that the pose path neither builds nor frees it.
struct MapCorrection {
  static constexpr std::size_t kMaxKeyframes = 1 << 14;  ///< more are not looked for
  /// Newest keyframes that it need not know: their points are kept, so that they go on in the new reference. A back end
  /// in another thread must fall no further behind.
  static constexpr int kMostAhead = 65;

  explicit MapCorrection(const ReferenceConfig& config) : reference(config) { keyframes.reserve(kMaxKeyframes); }
  Reference reference;
  std::vector<ReferenceKeyframe> keyframes;  ///< in the reference, by id; the FrontEnd adds to them
  std::optional<Pose2> T_map_session;        ///< set: the lost session has been found here in the map
  bool refuted = false;      ///< set, with nothing else: the map contradicts the pose that a person gave
  std::int32_t map_id = 0;   ///< of the map that it corrects
  std::int32_t session = 0;  ///< that the robot was in; void in another one
  int newest = -1;           ///< newest keyframe that the back end knew
};

}  // namespace slam
