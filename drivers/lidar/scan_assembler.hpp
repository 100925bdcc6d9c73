// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "core/scan.hpp"
#include "drivers/lidar/lidar_decoder.hpp"

namespace slam {

/// Collects measurement nodes to one LaserScan a turn: metres, radians counter-clockwise, each beam with its own time.
///
/// A node without echo carries the angle that its unit measured, not the one corrected for the distance, which is some
/// degrees off its neighbours'. Such beams are placed between the echoes around them, so that bearings stay in the
/// order of acquisition. A turn with more nodes than a scan holds is thinned evenly: one of two of them is used, or of
/// four.
class ScanAssembler {
 public:
  struct Limits {
    float range_min = 0.15F, range_max = 12.0F;  ///< [m]
    bool clockwise = true;                       ///< sense of the nodes' angles, seen from above
    bool exact_bearings = false;                 ///< of nodes without echo, too: none is placed anew
  };
  explicit ScanAssembler(const Limits& limits) : sense_(limits.clockwise ? -1 : 1), places_(!limits.exact_bearings) {
    scan_.range_min = limits.range_min, scan_.range_max = limits.range_max;
  }

  /// @param stamp when the node was sampled
  /// @return the finished turn when this node starts the next one (valid until the next add()); the turn in which the
  ///         stream began is not whole and never returned
  const LaserScan* add(const LidarNode& node, Timestamp stamp);
  /// The turn has ended with the node before. @return it, as add() does
  const LaserScan* endTurn();
  void reset();

  std::int64_t thinned() const { return thinned_; }  ///< beams left out because a turn had too many
  int stride() const { return finished_stride_; }    ///< one of so many is used in the last finished turn
  std::uint32_t broken() const { return broken_; }   ///< turns given up because the start of the next was lost
  std::uint32_t turns() const { return turns_; }     ///< that the head has made, given up or not

 private:
  const LaserScan* finish();
  void push(const Beam& beam);

  int sense_;    // of a bearing where the angle rises
  bool places_;  // beams without echo between the others
  LaserScan scan_, finished_;
  bool whole_ = false;
  int last_angle_q6_ = 0, turned_q6_ = 0;  // [deg * 64] since the turn's start
  std::uint32_t broken_ = 0, turns_ = 0;
  std::int64_t thinned_ = 0;
  int stride_ = 1, skip_ = 0, finished_stride_ = 1;  // of the turn under way; nodes to leave out; of the last turn
};

}  // namespace slam
