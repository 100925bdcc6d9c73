// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <limits>
#include <vector>

#include "tools/sim/world/solids.hpp"

namespace slam::sim {

/// Someone who walks to and fro along a path: two legs whose feet swing, and a torso above them.
struct Person {
  static constexpr double kLegRadius = 0.07, kHipHeight = 0.8;   ///< [m]
  static constexpr double kTorsoRadius = 0.20, kTorsoTop = 1.7;  ///< [m]
  static constexpr double kFeetApart = 0.20;                     ///< [m] across the way
  static constexpr double kSwing = 0.22, kStride = 1.2;          ///< [m] of a foot; of both steps

  std::vector<Eigen::Vector2d> path;  ///< [m] two points at least, no two in a row the same
  double speed = 0.8;                 ///< [m/s]
  double begin = 0.0, end = 0.0;      ///< [s] since the drive began; before and after, the person is not there

  bool present(double time) const { return time >= begin && time < end; }
  /// Middle of the body at a time when the person is there.
  Eigen::Vector2d position(double time) const;
  /// Adds the person's body, if there at that time.
  void addTo(Solids& solids, double time) const;
};

/// Something that stands at one place and, from a time on, at another; a door also goes back.
struct MovedThing {
  Solids before, after;
  double time = 0.0;                                      ///< [s] since the drive began
  double back = std::numeric_limits<double>::infinity();  ///< [s] from then on it stands as before

  const Solids& at(double now) const { return now >= time && now < back ? after : before; }
  const Solids& lasting() const { return std::isinf(back) ? after : before; }
};

}  // namespace slam::sim
