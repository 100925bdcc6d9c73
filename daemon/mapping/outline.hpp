// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

namespace slam {

/// Corners of a polygon [m], in either direction; the last one is joined to the first.
using Outline = std::vector<Eigen::Vector2d>;

/// Whether a point lies within a polygon, by the even-odd rule.
bool holds(std::span<const Eigen::Vector2d> outline, const Eigen::Vector2d& point);
/// [m] from a point to the line from a to b
double distanceTo(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& point);
/// Whether a point is no further than `reach` [m] from an edge. @param closed the last point is joined to the first
bool touches(std::span<const Eigen::Vector2d> outline, bool closed, const Eigen::Vector2d& point, double reach);
/// Whether edges of a polygon touch or cross each other elsewhere than in the corner that they share.
bool crossesItself(std::span<const Eigen::Vector2d> outline);

/// A rectangle with sides along the axes [m].
struct Bounds {
  Eigen::Vector2d low, high;
  /// Of some points. @pre not empty
  static Bounds of(std::span<const Eigen::Vector2d> points);
  bool meets(const Bounds& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
  bool holds(const Eigen::Vector2d& p) const {
    return (low.array() <= p.array()).all() && (p.array() <= high.array()).all();
  }
  Bounds grown(double by) const { return {low.array() - by, high.array() + by}; }
};

}  // namespace slam
