// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "core/pose2.hpp"
#include "core/pseudo_laser.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// What is stored of a pseudo-laser: the beams that say something.
struct DepthView {
  struct Beam {
    float bearing;    ///< [rad] in the levelled camera's frame
    float range;      ///< [m] of the hit, or free up to here
    float free_from;  ///< [m] nearer than this nothing is known; `range`: nothing is known to be free
    float solid_to;   ///< [m] of a hit: as far the obstacle was seen to go on
    bool hit;
  };

  Timestamp stamp;
  Pose2 T_base_depth;  ///< of the levelled camera
  std::vector<Beam> beams;

  DepthView() = default;
  DepthView(const PseudoLaser& laser, const Pose2& T_base_camera) : stamp(laser.stamp), T_base_depth(T_base_camera) {
    for (int i = 0; i < laser.size; ++i) {
      const PseudoBeam& beam = laser.storage[static_cast<std::size_t>(i)];
      if (beam.kind == PseudoBeam::Kind::kUnknown) continue;
      const bool hit = beam.kind == PseudoBeam::Kind::kHit;
      const float bearing = laser.bearing_min + static_cast<float>(i) * laser.bearing_step;
      beams.push_back({bearing, beam.range, beam.free_from, hit ? beam.solid_to : beam.range, hit});
    }
  }
};

}  // namespace slam
