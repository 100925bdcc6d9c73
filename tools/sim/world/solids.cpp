// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/solids.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace slam::sim {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// The part of a ray between two parallel planes, narrowed by each call.
struct Interval {
  double enter = 0.0, leave = kNever;

  void clip(double origin, double direction, double low, double high) {
    if (std::abs(direction) < 1e-12) {
      if (origin < low || origin > high) leave = -1.0;
      return;
    }
    const double a = (low - origin) / direction, b = (high - origin) / direction;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  double hit() const { return enter <= leave ? enter : kNever; }
};

double castBox(const Box& box, const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
  const double c = std::cos(box.yaw), s = std::sin(box.yaw);
  const double dx = from.x() - box.x, dy = from.y() - box.y;
  Interval interval;
  interval.clip(c * dx + s * dy, c * direction.x() + s * direction.y(), -box.length / 2, box.length / 2);
  interval.clip(-s * dx + c * dy, -s * direction.x() + c * direction.y(), -box.width / 2, box.width / 2);
  interval.clip(from.z(), direction.z(), box.bottom, box.top);
  return interval.hit();
}

/// Roots of the ray with a circle or sphere: |o + t d|^2 = r^2. @return first and second, or nothing
std::optional<std::pair<double, double>> roots(double dd, double od, double oo, double radius) {
  const double discriminant = od * od - dd * (oo - radius * radius);
  if (dd < 1e-12 || discriminant < 0.0) return std::nullopt;
  const double root = std::sqrt(discriminant);
  return std::pair((-od - root) / dd, (-od + root) / dd);
}

double castCylinder(const Cylinder& cylinder, const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
  const Eigen::Vector2d o(from.x() - cylinder.x, from.y() - cylinder.y), d = direction.head<2>();
  const auto side = roots(d.squaredNorm(), o.dot(d), o.squaredNorm(), cylinder.radius);
  if (!side) return kNever;
  Interval interval{std::max(0.0, side->first), side->second};
  interval.clip(from.z(), direction.z(), cylinder.bottom, cylinder.top);
  return interval.hit();
}

double castSphere(const Sphere& sphere, const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d o = from - Eigen::Vector3d(sphere.x, sphere.y, sphere.z);
  const auto hit = roots(direction.squaredNorm(), o.dot(direction), o.squaredNorm(), sphere.radius);
  return hit && hit->second >= 0.0 ? std::max(0.0, hit->first) : kNever;
}

}  // namespace

void Solids::append(const Solids& others) {
  boxes.insert(boxes.end(), others.boxes.begin(), others.boxes.end());
  cylinders.insert(cylinders.end(), others.cylinders.begin(), others.cylinders.end());
  spheres.insert(spheres.end(), others.spheres.begin(), others.spheres.end());
}

void Solids::clear() {
  boxes.clear();
  cylinders.clear();
  spheres.clear();
}

double Solids::castRay(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const {
  double nearest = kNever;
  for (const Box& box : boxes) nearest = std::min(nearest, castBox(box, from, direction));
  for (const Cylinder& cylinder : cylinders) nearest = std::min(nearest, castCylinder(cylinder, from, direction));
  for (const Sphere& sphere : spheres) nearest = std::min(nearest, castSphere(sphere, from, direction));
  return nearest;
}

bool Solids::occupied(const Eigen::Vector2d& p, double bottom, double top, double margin) const {
  for (const Box& box : boxes) {
    if (box.top < bottom || box.bottom > top) continue;
    const double c = std::cos(box.yaw), s = std::sin(box.yaw);
    const double dx = p.x() - box.x, dy = p.y() - box.y;
    const double along = std::max(0.0, std::abs(c * dx + s * dy) - box.length / 2);
    const double across = std::max(0.0, std::abs(-s * dx + c * dy) - box.width / 2);
    if (std::hypot(along, across) <= margin) return true;
  }
  for (const Cylinder& cylinder : cylinders) {
    if (cylinder.top < bottom || cylinder.bottom > top) continue;
    if (std::hypot(p.x() - cylinder.x, p.y() - cylinder.y) <= cylinder.radius + margin) return true;
  }
  for (const Sphere& sphere : spheres) {
    const double z = std::clamp(sphere.z, bottom, top) - sphere.z;  // the band's height nearest to the centre
    if (std::abs(z) > sphere.radius) continue;
    const double radius = std::sqrt(sphere.radius * sphere.radius - z * z);
    if (std::hypot(p.x() - sphere.x, p.y() - sphere.y) <= radius + margin) return true;
  }
  return false;
}

Bounds Solids::bounds() const {
  Bounds bounds;
  const auto include = [&](double x, double y, double reach_x, double reach_y) {
    bounds.low = bounds.low.cwiseMin(Eigen::Vector2d(x - reach_x, y - reach_y));
    bounds.high = bounds.high.cwiseMax(Eigen::Vector2d(x + reach_x, y + reach_y));
  };
  for (const Box& box : boxes) {
    const double c = std::abs(std::cos(box.yaw)) / 2, s = std::abs(std::sin(box.yaw)) / 2;
    include(box.x, box.y, c * box.length + s * box.width, s * box.length + c * box.width);
  }
  for (const Cylinder& cylinder : cylinders) include(cylinder.x, cylinder.y, cylinder.radius, cylinder.radius);
  for (const Sphere& sphere : spheres) include(sphere.x, sphere.y, sphere.radius, sphere.radius);
  return bounds;
}

}  // namespace slam::sim
