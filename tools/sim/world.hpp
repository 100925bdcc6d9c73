// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <optional>
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

/// Everything that stands on a flat floor, z = 0.
class World {
 public:
  void add(const Box& box) { boxes_.push_back(box); }
  void add(const Cylinder& cylinder) { cylinders_.push_back(cylinder); }
  void add(const Sphere& sphere) { spheres_.push_back(sphere); }
  /// A wall of the given thickness from one point to another.
  void addWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double thickness = 0.1, double top = 2.5);

  /// @param direction unit vector
  /// @return distance to the first surface [m], the floor not counted; std::nullopt when there is none within `reach`
  std::optional<double> castRay(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double reach) const;

  /// Does anything between the heights `bottom` and `top` come within `margin` [m] of the point, seen from above?
  bool occupied(const Eigen::Vector2d& p, double bottom, double top, double margin = 0.0) const;

  struct Bounds {
    Eigen::Vector2d low, high;  ///< [m]
  };
  Bounds bounds() const;

 private:
  std::vector<Box> boxes_;
  std::vector<Cylinder> cylinders_;
  std::vector<Sphere> spheres_;
};

}  // namespace slam::sim
