// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <span>

#include "depth/depth_rays.hpp"

namespace slam {

/// The heights that must be looked through before a place is free, seen from the camera, for one beam.
struct HeightWindow {
  double down = 0.0;       ///< [m] from the camera down to the floor clearance
  double up = 0.0;         ///< [m] from the camera up to the robot's top; negative: the camera sits higher
  double lift = 0.0;       ///< [1] height per distance that the floor's tilt adds
  double range_min = 0.0;  ///< [m] nearer depth is not trusted
};

/// At which distances along one beam a depth camera sees all heights of the window.
class VisibleRanges {
 public:
  /// @param valid by band: pixels that hold a depth. A band with few of them is blind where it looks into the window.
  VisibleRanges(std::span<const DepthRays::Band> bands, std::span<const int> valid, const HeightWindow& window);

  /// [m] free space before an obstacle at `range` begins here: nearer, something may have been overlooked
  double freeBefore(double range) const;

  struct RangeInterval {
    double from, to;  ///< [m]
  };
  /// The first interval in which all heights were looked through; empty (to <= from) when there is none.
  /// @param range_max [m] its end at most
  RangeInterval freeInterval(double range_max) const;

 private:
  void addBlind(const DepthRays::Band& band, const HeightWindow& window);

  double covered_from_;                                 // [m] nearer than this not all heights are in view
  std::array<RangeInterval, DepthRays::kBands> blind_;  // by beginning
  std::size_t blind_count_ = 0;
};

}  // namespace slam
