// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "core/pseudo_laser.hpp"
#include "frontend/front_end_state.hpp"
#include "frontend/local_map.hpp"

namespace slam {

/// When what the depth camera sees is drawn. Views from one place have the same errors: many of them prove no more than
/// one, but they show what has changed there.
struct DepthViewConfig {
  double time_offset = 0.0;   ///< [s] added to the camera's stamps
  double translation = 0.05;  ///< [m] since the last view
  double rotation = 0.05;     ///< [rad] since the last view
  double period = 0.2;        ///< [s] since the last view

  void visitSettings(auto& v) {
    v.expert("time_offset", time_offset, "s", -1.0, 1.0, "This time is added to the stamps of the depth images.");
  }
};

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
