// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/world.hpp"

#include <algorithm>
#include <cmath>

namespace slam::sim {

void World::add(const Person& person) {
  persons_.push_back(person);
  setTime(time_);
}

void World::add(const MovedThing& thing) {
  moved_.push_back(thing);
  lasting_.append(thing.after);
  setTime(time_);
}

void World::addWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double thickness, double top) {
  const Eigen::Vector2d middle = 0.5 * (from + to), along = to - from;
  add(Box{middle.x(), middle.y(), std::atan2(along.y(), along.x()), along.norm() + thickness, thickness, 0.0, top});
}

void World::setTime(double time) {
  time_ = time;
  moving_.clear();
  for (const Person& person : persons_) person.addTo(moving_, time);
  for (const MovedThing& thing : moved_) moving_.append(time < thing.time ? thing.before : thing.after);
}

std::optional<double> World::castRay(const Eigen::Vector3d& from, const Eigen::Vector3d& direction,
                                     double reach) const {
  const double nearest = std::min(still_.castRay(from, direction), moving_.castRay(from, direction));
  return nearest <= reach ? std::optional(nearest) : std::nullopt;
}

bool World::occupied(const Eigen::Vector2d& p, double bottom, double top, double margin) const {
  return still_.occupied(p, bottom, top, margin) || lasting_.occupied(p, bottom, top, margin);
}

Bounds World::bounds() const {
  Bounds bounds = still_.bounds();
  const Bounds moved = lasting_.bounds();
  bounds.low = bounds.low.cwiseMin(moved.low);
  bounds.high = bounds.high.cwiseMax(moved.high);
  return bounds;
}

}  // namespace slam::sim
