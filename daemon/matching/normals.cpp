// SPDX-License-Identifier: BSD-3-Clause
#include "matching/normals.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

/// Moments of the neighbours about the point itself.
struct Moments {
  double n = 1.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;

  void add(const Eigen::Vector2d& d) {
    n += 1.0;
    x += d.x();
    y += d.y();
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
};

void addSide(const ScanPoints& points, std::size_t centre, int step, double max_gap, const NormalConfig& config,
             Moments& moments) {
  const Eigen::Vector2d& p = points[centre].position;
  Eigen::Vector2d previous = p;
  const double support = config.min_support * config.min_support;
  auto j = static_cast<std::ptrdiff_t>(centre);
  for (int k = 0; k < config.max_neighbours; ++k) {
    j += step;
    if (j < 0 || j >= static_cast<std::ptrdiff_t>(points.size())) return;
    const Eigen::Vector2d& q = points[static_cast<std::size_t>(j)].position;
    if ((q - previous).squaredNorm() > max_gap * max_gap) return;
    const Eigen::Vector2d d = q - p;
    moments.add(d);
    if (d.squaredNorm() > support) return;
    previous = q;
  }
}

}  // namespace

void estimateNormals(ScanPoints& points, const Eigen::Vector2d& lidar, const NormalConfig& config) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    ScanPoint& point = points[i];
    point.normal.setZero();
    const double max_gap = std::max(config.max_gap, config.max_gap_per_range * point.range);
    Moments m;
    addSide(points, i, -1, max_gap, config, m);
    addSide(points, i, +1, max_gap, config, m);
    if (m.n < 1.0 + config.min_neighbours) continue;

    const double sxx = m.xx - m.x * m.x / m.n, sxy = m.xy - m.x * m.y / m.n, syy = m.yy - m.y * m.y / m.n;
    const double spread = std::hypot(sxx - syy, 2.0 * sxy);
    const double along = 0.5 * (sxx + syy + spread), across = std::max(0.0, 0.5 * (sxx + syy - spread));
    if (across / m.n > config.max_line_error * config.max_line_error || along < 8.0 * across) continue;
    const double variance = std::max(config.range_sigma * config.range_sigma, across / (m.n - 2.0 + 1e-9)) / along;
    if (!(variance < 0.15)) continue;  // more than 22 degrees: it says nothing

    const double angle = 0.5 * std::atan2(2.0 * sxy, sxx - syy);
    Eigen::Vector2d normal(-std::sin(angle), std::cos(angle));
    if (normal.dot(lidar - point.position) < 0.0) normal = -normal;
    point.normal = normal;
    point.normal_variance = variance;
  }
}

}  // namespace slam
