// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/depth_view_selector.hpp"

#include <cmath>

namespace slam {

const DepthObservation* DepthViewSelector::select(const PseudoLaser& laser, Timestamp stamp, const Pose2& T_odom_base,
                                                  std::int32_t map_id, std::int32_t session,
                                                  const AnchoredPose& where) {
  if (!isNew(stamp, T_odom_base)) return nullptr;
  last_ = T_odom_base;
  last_stamp_ = stamp;
  ++drawn_;
  sight_ = {map_id, session, where.keyframe, where.T_keyframe_base, laser};
  return &sight_;
}

const DepthObservation* DepthViewSelector::leaveOut() {
  ++unplaced_;
  return nullptr;
}

bool DepthViewSelector::isNew(Timestamp stamp, const Pose2& T_odom_base) const {
  if (!last_ || stamp - last_stamp_ >= fromSeconds(config_.period) || stamp < last_stamp_) return true;
  const Pose2 moved = between(*last_, T_odom_base);
  return std::hypot(moved.x, moved.y) >= config_.translation || std::abs(moved.theta) >= config_.rotation;
}

void DepthViewSelector::addTo(FrontEndCounters& counters) const {
  counters.views = drawn_;
  counters.views_unplaced = unplaced_;
}

}  // namespace slam
