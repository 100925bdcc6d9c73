// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "tools/sim/world/moving_things.hpp"
#include "tools/sim/world/solids.hpp"

namespace slam::sim {

/// Everything that stands on a flat floor, z = 0, at the time it was set to.
class World {
 public:
  static constexpr double kCeiling = 2.5;  ///< [m] above the floor

  void add(const Box& box) { add(Solids{.boxes = {box}}); }
  void add(const Cylinder& cylinder) { add(Solids{.cylinders = {cylinder}}); }
  void add(const Sphere& sphere) { add(Solids{.spheres = {sphere}}); }
  void add(const Solids& solids);
  void add(const Person& person);
  void add(const MovedThing& thing);
  /// A wall of the given thickness from one point to another.
  void addWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double thickness = 0.1, double top = kCeiling);

  /// Puts persons and moved things where they are at that time. A world begins at time 0.
  /// @param time [s] since the drive began
  void setTime(double time);

  /// @param direction unit vector
  /// @return distance to the first surface [m], floor and ceiling not counted; std::nullopt when there is none within
  ///         `reach`
  std::optional<double> castRay(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double reach) const;

  /// Does anything that lasts come within `margin` [m] of the point between the heights `bottom` and `top`, seen from
  /// above? Persons do not last, and a moved thing is where it was put, whatever the time.
  bool occupied(const Eigen::Vector2d& p, double bottom, double top, double margin = 0.0) const;

  /// Of all that lasts.
  Bounds bounds() const;

  const Solids& still() const { return still_; }
  /// Persons and moved things at the present time.
  const Solids& moving() const { return moving_; }
  const std::vector<Person>& persons() const { return persons_; }

 private:
  Solids still_, moving_;
  Bounds still_bounds_;
  std::map<std::pair<int, int>, Solids> tiles_;  // of the floor, with all still things that reach into each
  Solids lasting_;                               // moved things where they end
  std::vector<Person> persons_;
  std::vector<MovedThing> moved_;
  double time_ = 0.0;  // [s]
};

}  // namespace slam::sim
