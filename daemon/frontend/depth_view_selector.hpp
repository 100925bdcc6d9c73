// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "core/pseudo_laser.hpp"
#include "frontend/front_end_config.hpp"
#include "frontend/local_map.hpp"

namespace slam {

/// Says which of the depth camera's images are drawn.
class DepthViewSelector {
 public:
  explicit DepthViewSelector(const DepthViewConfig& config) : config_(config) {}

  /// @param stamp in the filters' time  @param where the robot was; nothing: its pose was not valid or known
  /// @return the image with its place, if it is to be drawn; valid until the next call
  const DepthObservation* select(const PseudoLaser& laser, Timestamp stamp, const Pose2& T_odom_base,
                                 std::int32_t map_id, std::int32_t session, const AnchoredPose& where);
  /// The robot's pose at an image's stamp is not known.
  const DepthObservation* leaveOut();

  void addTo(FrontEndCounters& counters) const;

 private:
  bool isNew(Timestamp stamp, const Pose2& T_odom_base) const;

  DepthViewConfig config_;
  std::optional<Pose2> last_;  // in odom
  Timestamp last_stamp_;
  DepthObservation sight_;
  std::uint32_t drawn_ = 0, unplaced_ = 0;
};

}  // namespace slam
