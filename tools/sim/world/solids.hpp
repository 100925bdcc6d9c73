// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <limits>
#include <vector>

namespace slam::sim {

/// Box with upright sides, turned about the vertical.
struct Box {
  double x = 0.0, y = 0.0, yaw = 0.0;  ///< [m, m, rad] of its centre
  double length = 1.0, width = 1.0;    ///< [m] along and across its yaw
  double bottom = 0.0, top = 2.5;      ///< [m] above the floor
};

/// Upright cylinder.
struct Cylinder {
  double x = 0.0, y = 0.0, radius = 0.1;  ///< [m]
  double bottom = 0.0, top = 1.0;         ///< [m] above the floor
};

struct Sphere {
  double x = 0.0, y = 0.0, z = 0.0, radius = 0.1;  ///< [m]
};

/// A rectangle of the floor.
struct Bounds {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());    ///< [m]
  Eigen::Vector2d high = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());  ///< [m]
};

/// Things of simple shape.
struct Solids {
  std::vector<Box> boxes = {};
  std::vector<Cylinder> cylinders = {};
  std::vector<Sphere> spheres = {};

  void append(const Solids& others);
  void clear();

  /// @param direction of any length > 0
  /// @return the smallest t >= 0 with from + t direction in one of the things; infinity when there is none
  double castRay(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const;
  /// Does anything between the heights `bottom` and `top` come within `margin` [m] of the point, seen from above?
  bool occupied(const Eigen::Vector2d& p, double bottom, double top, double margin) const;
  Bounds bounds() const;
};

}  // namespace slam::sim
