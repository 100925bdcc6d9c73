// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "core/scan.hpp"
#include "drivers/lidar/codec/rplidar_codec.hpp"

namespace slam::rplidar {

/// Collects measurement nodes to one LaserScan a turn: metres, radians counter-clockwise, each beam with its own time.
///
/// A node without echo carries the angle that its unit measured, not the one corrected for the distance, which is some
/// degrees off its neighbours'. Such beams are placed between the echoes around them, so that bearings stay in the
/// order of acquisition.
class ScanAssembler {
 public:
  struct Limits {
    float range_min = 0.15F, range_max = 12.0F;  ///< [m]
  };
  explicit ScanAssembler(const Limits& limits) {
    scan_.range_min = limits.range_min, scan_.range_max = limits.range_max;
  }

  /// @param stamp when the node was sampled
  /// @return the finished turn when this node starts the next one (valid until the next add()); the turn in which the
  ///         stream began is not whole and never returned
  const LaserScan* add(const Node& node, Timestamp stamp);
  void reset();

  std::uint32_t overfull() const { return overfull_; }  ///< beams that did not fit into a scan
  std::uint32_t broken() const { return broken_; }      ///< turns given up because the start of the next was lost
  std::uint32_t turns() const { return turns_; }        ///< that the head has made, given up or not

 private:
  const LaserScan* finish();

  LaserScan scan_, finished_;
  bool whole_ = false;
  int last_angle_q6_ = 0, turned_q6_ = 0;  // [deg * 64] since the turn's start
  std::uint32_t overfull_ = 0, broken_ = 0, turns_ = 0;
};

}  // namespace slam::rplidar
