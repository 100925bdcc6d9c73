// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/moving_things.hpp"

#include <cmath>
#include <numbers>

namespace slam::sim {
namespace {

struct Walker {
  Eigen::Vector2d position, heading;  // [m]; unit vector along the path's segment
};

double length(const std::vector<Eigen::Vector2d>& path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
  return sum;
}

/// @param way [m] walked since the path's first point, there and back again as often as needed
Walker walk(const std::vector<Eigen::Vector2d>& path, double way) {
  const double whole = length(path);
  const double phase = std::fmod(way, 2.0 * whole);
  double left = phase < whole ? phase : 2.0 * whole - phase;
  for (std::size_t i = 1;; ++i) {
    const Eigen::Vector2d segment = path[i] - path[i - 1];
    if (left <= segment.norm() || i + 1 == path.size()) {
      const Eigen::Vector2d heading = segment.normalized();
      return {path[i - 1] + left * heading, heading};
    }
    left -= segment.norm();
  }
}

}  // namespace

Eigen::Vector2d Person::position(double time) const { return walk(path, speed * (time - begin)).position; }

void Person::addTo(Solids& solids, double time) const {
  if (!present(time)) return;
  const double way = speed * (time - begin);
  const auto [middle, heading] = walk(path, way);
  const Eigen::Vector2d left(-heading.y(), heading.x());
  const double swing = kSwing * std::sin(2.0 * std::numbers::pi * way / kStride);
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector2d foot = middle + side * (kFeetApart / 2 * left + swing * heading);
    solids.cylinders.push_back({foot.x(), foot.y(), kLegRadius, 0.0, kHipHeight});
  }
  solids.cylinders.push_back({middle.x(), middle.y(), kTorsoRadius, kHipHeight, kTorsoTop});
}

}  // namespace slam::sim
