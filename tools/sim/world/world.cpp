// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/world.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace slam::sim {
namespace {

constexpr double kTile = 40.0;  // [m] of which the one about the origin holds a whole small world

constexpr double kFar = 1e6;  // [m] as good as infinity, which times zero is no number

int tileOf(double coordinate) { return static_cast<int>(std::floor(coordinate / kTile + 0.5)); }

}  // namespace

void World::add(const Solids& solids) {
  still_.append(solids);
  const auto put = [this](const auto& thing, std::vector<std::decay_t<decltype(thing)>> Solids::*kind) {
    Solids alone;
    (alone.*kind).push_back(thing);
    const Bounds bounds = alone.bounds();
    still_bounds_.low = still_bounds_.low.cwiseMin(bounds.low);
    still_bounds_.high = still_bounds_.high.cwiseMax(bounds.high);
    for (int x = tileOf(bounds.low.x()); x <= tileOf(bounds.high.x()); ++x) {
      for (int y = tileOf(bounds.low.y()); y <= tileOf(bounds.high.y()); ++y) (tiles_[{x, y}].*kind).push_back(thing);
    }
  };
  for (const Box& box : solids.boxes) put(box, &Solids::boxes);
  for (const Cylinder& cylinder : solids.cylinders) put(cylinder, &Solids::cylinders);
  for (const Sphere& sphere : solids.spheres) put(sphere, &Solids::spheres);
}

void World::add(const Person& person) {
  persons_.push_back(person);
  setTime(time_);
}

void World::add(const MovedThing& thing) {
  moved_.push_back(thing);
  lasting_.append(thing.lasting());
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
  for (const MovedThing& thing : moved_) moving_.append(thing.at(time));
}

std::optional<double> World::castRay(const Eigen::Vector3d& from, const Eigen::Vector3d& direction,
                                     double reach) const {
  const Eigen::Vector2d start = from.head<2>(), end = start + std::min(reach, kFar) * direction.head<2>();
  const Eigen::Vector2d low = start.cwiseMin(end).cwiseMax(still_bounds_.low);
  const Eigen::Vector2d high = start.cwiseMax(end).cwiseMin(still_bounds_.high);
  double nearest = moving_.castRay(from, direction);
  if ((low.array() <= high.array()).all()) {
    for (int x = tileOf(low.x()); x <= tileOf(high.x()); ++x) {
      for (int y = tileOf(low.y()); y <= tileOf(high.y()); ++y) {
        const auto tile = tiles_.find({x, y});
        if (tile != tiles_.end()) nearest = std::min(nearest, tile->second.castRay(from, direction));
      }
    }
  }
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
