// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "core/pose2.hpp"
#include "core/pseudo_laser.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// What is stored of a pseudo-laser: the beams that say something, and the surfaces behind.
struct DepthView {
  struct Beam {
    float bearing;    ///< [rad] in the levelled camera's frame
    float range;      ///< [m] of the hit, or free up to here
    float free_from;  ///< [m] nearer than this nothing is known; `range`: nothing is known to be free
    bool hit;
  };
  struct Surface {
    float bearing;   ///< [rad]
    float from, to;  ///< [m]
  };

  Timestamp stamp;
  Pose2 T_base_depth;  ///< of the levelled camera
  std::vector<Beam> beams;
  std::vector<Surface> surfaces;

  DepthView() = default;
  DepthView(const PseudoLaser& laser, const Pose2& T_base_camera) : stamp(laser.stamp), T_base_depth(T_base_camera) {
    for (int i = 0; i < laser.size; ++i) {
      const PseudoBeam& beam = laser.storage[static_cast<std::size_t>(i)];
      if (beam.kind == PseudoBeam::Kind::kUnknown) continue;
      beams.push_back({laser.bearing(i), beam.range, beam.free_from, beam.kind == PseudoBeam::Kind::kHit});
    }
    for (const PseudoLaser::Surface& surface : laser.surfaces()) {
      surfaces.push_back({laser.bearing(surface.beam), surface.from, surface.to});
    }
  }
};

}  // namespace slam
