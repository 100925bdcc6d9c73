// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "core/scan.hpp"
#include "drivers/rplidar_codec.hpp"

namespace slam::rplidar {

/// Collects measurement nodes to one LaserScan a turn: metres, radians counter-clockwise, each beam with its own time.
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

 private:
  LaserScan scan_, finished_;
  bool whole_ = false;
  std::uint32_t overfull_ = 0;
};

}  // namespace slam::rplidar
