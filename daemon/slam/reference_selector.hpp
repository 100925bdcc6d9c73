// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "frontend/map_correction.hpp"
#include "slam/back_end_config.hpp"
#include "slam/keyframe_map.hpp"

namespace slam {

/// Chooses the keyframes that the front end may match against: those whose position relative to the robot is known. Old
/// ones that the robot's drift has lost touch with come back only when a loop closure has put them in place, so that
/// two copies of one wall never pull at a scan. Makes the corrections that bring them to the front end.
class ReferenceSelector {
 public:
  explicit ReferenceSelector(const BackEndConfig& config) : config_(config) {}

  /// A correction becomes due if the reference is not what it should be for a robot at keyframe `anchor`.
  /// @param stale it is not, by what is known already
  void renew(KeyframeMap& map, int anchor, std::int32_t session, bool stale = false);
  /// A correction becomes due that holds these keyframes. @param robot [m] in map
  void renew(KeyframeMap& map, const Eigen::Vector2d& robot, std::span<const int> ids, std::int32_t session);
  /// The correction that is due places the session, too.
  void place(const Pose2& T_map_session) { due_->T_map_session = T_map_session; }
  /// Instead of a correction: the map contradicts the pose that a person gave.
  void refute(std::int32_t session);

  std::unique_ptr<MapCorrection> take() { return std::move(due_); }
  void recycle(std::unique_ptr<MapCorrection> used) { spare_ = std::move(used); }
  int made() const { return made_; }  ///< corrections

 private:
  void begin(std::int32_t session);

  BackEndConfig config_;
  std::unique_ptr<MapCorrection> due_, spare_;
  NodeSet known_;  // scratch
  int made_ = 0;
};

}  // namespace slam
