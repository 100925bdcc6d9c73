// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/situation/panes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace slam::sim {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kProud = 0.005;                   // [m] that a pane stands in front of its wall
constexpr double kWallTop = 2.0, kThickest = 0.2;  // [m] of a box that is a wall
constexpr double kShortest = 1.0, kLongest = 2.0;  // [m] of a pane
constexpr double kSquarely = 0.966;                // cosine of 15 degrees
constexpr double kDirty = 0.2;                     // share of beams that dirt sends back
constexpr int kReflections = 3;

/// Of the face of an upright box that p is nearest to.
Eigen::Vector3d normalAt(const Box& box, const Eigen::Vector3d& p) {
  const double c = std::cos(box.yaw), s = std::sin(box.yaw), dx = p.x() - box.x, dy = p.y() - box.y;
  const double along = c * dx + s * dy, across = -s * dx + c * dy;
  const Eigen::Vector3d face = std::abs(std::abs(along) - box.length / 2) < std::abs(std::abs(across) - box.width / 2)
                                   ? Eigen::Vector3d(c, s, 0.0)
                                   : Eigen::Vector3d(-s, c, 0.0);
  return face;
}

}  // namespace

Panes::Panes(std::vector<Pane> panes, std::uint64_t seed)
    : panes_(std::move(panes)), random_(seed ^ 0xBF58476D1CE4E5B9ULL) {}

Panes Panes::drawn(const World& world, int glass, int mirrors, std::uint64_t seed) {
  std::vector<Box> walls;
  for (Box box : world.still().boxes) {
    if (box.top < kWallTop || std::min(box.length, box.width) > kThickest) continue;
    if (box.length < box.width) {
      std::swap(box.length, box.width);
      box.yaw += std::acos(0.0);
    }
    if (box.length >= kShortest) walls.push_back(box);
  }
  std::vector<Pane> panes;
  std::mt19937_64 random(seed ^ 0x94D049BB133111EBULL);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < glass + mirrors && !walls.empty(); ++i) {
    Box box = walls[std::uniform_int_distribution<std::size_t>(0, walls.size() - 1)(random)];
    const double length = uniform(kShortest, std::min(kLongest, box.length));
    const double along = uniform(-0.5, 0.5) * (box.length - length);
    box.x += along * std::cos(box.yaw);
    box.y += along * std::sin(box.yaw);
    box.length = length;
    box.width += 2.0 * kProud;
    panes.push_back({box, i >= glass});
  }
  return {std::move(panes), seed};
}

double Panes::castRay(const World& world, const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double reach) {
  Eigen::Vector3d at = from, ray = direction;
  double way = 0.0;
  for (int i = 0; i <= kReflections; ++i) {
    double nearest = world.castRay(at, ray, reach - way).value_or(kNever);
    const Pane* met = nullptr;
    for (const Pane& pane : panes_) {
      const double hit = Solids{.boxes = {pane.box}}.castRay(at, ray);
      if (hit < nearest && way + hit <= reach) {
        nearest = hit;
        met = &pane;
      }
    }
    if (!met) return way + nearest;
    const Eigen::Vector3d surface = at + nearest * ray, normal = normalAt(met->box, surface);
    way += nearest;
    if (!met->mirror) {
      const bool back =
          std::abs(normal.dot(ray)) >= kSquarely || std::uniform_real_distribution<double>(0.0, 1.0)(random_) < kDirty;
      return back ? way : kNever;
    }
    ray -= 2.0 * normal.dot(ray) * normal;
    at = surface + 1e-6 * ray;
  }
  return kNever;
}

}  // namespace slam::sim
