// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/outline.hpp"

#include <algorithm>
#include <array>

namespace slam {
namespace {

using Point = Eigen::Vector2d;

/// [m^2] twice the area of a triangle, positive where a, b and c are counterclockwise
double turn(const Point& a, const Point& b, const Point& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Whether a point on the line through a and b lies between them.
bool between(const Point& a, const Point& b, const Point& p) {
  return std::min(a.x(), b.x()) <= p.x() && p.x() <= std::max(a.x(), b.x()) && std::min(a.y(), b.y()) <= p.y() &&
         p.y() <= std::max(a.y(), b.y());
}

bool meet(const Point& a, const Point& b, const Point& c, const Point& d) {
  const double abc = turn(a, b, c), abd = turn(a, b, d), cda = turn(c, d, a), cdb = turn(c, d, b);
  if (((abc > 0.0 && abd < 0.0) || (abc < 0.0 && abd > 0.0)) && ((cda > 0.0 && cdb < 0.0) || (cda < 0.0 && cdb > 0.0)))
    return true;
  return (abc == 0.0 && between(a, b, c)) || (abd == 0.0 && between(a, b, d)) || (cda == 0.0 && between(c, d, a)) ||
         (cdb == 0.0 && between(c, d, b));
}

}  // namespace

bool holds(std::span<const Point> outline, const Point& point) {
  bool inside = false;
  for (std::size_t i = 0, before = outline.size() - 1; i < outline.size(); before = i++) {
    const Point &a = outline[before], &b = outline[i];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    if (point.x() < a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

double distanceTo(const Point& a, const Point& b, const Point& point) {
  const Point along = b - a;
  const double squared = along.squaredNorm();
  const double share = squared > 0.0 ? std::clamp((point - a).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (point - a - share * along).norm();
}

bool touches(std::span<const Point> outline, bool closed, const Point& point, double reach) {
  for (std::size_t i = closed ? 0 : 1; i < outline.size(); ++i) {
    const Point &before = outline[i > 0 ? i - 1 : outline.size() - 1], &here = outline[i];
    const bool near = Bounds::of(std::array{before, here}).grown(reach).holds(point);
    if (near && distanceTo(before, here, point) <= reach) return true;
  }
  return false;
}

bool crossesItself(std::span<const Point> outline) {
  const std::size_t corners = outline.size();
  for (std::size_t i = 0; i < corners; ++i) {
    const Point &a = outline[i], &b = outline[(i + 1) % corners], &next = outline[(i + 2) % corners];
    // Neighbours share a corner; they may not lead back upon each other.
    if (a == b || (turn(a, b, next) == 0.0 && (b - a).dot(next - b) < 0.0)) return true;
    for (std::size_t k = i + 2; k < corners; ++k) {
      if (i == 0 && k == corners - 1) continue;  // neighbours, too
      if (meet(a, b, outline[k], outline[(k + 1) % corners])) return true;
    }
  }
  return false;
}

Bounds Bounds::of(std::span<const Point> points) {
  Bounds bounds{points.front(), points.front()};
  for (const Point& point : points) {
    bounds.low = bounds.low.cwiseMin(point);
    bounds.high = bounds.high.cwiseMax(point);
  }
  return bounds;
}

}  // namespace slam
