// SPDX-License-Identifier: BSD-3-Clause
#include "matching/normals.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace slam {
namespace {

constexpr double kSpacingBin = 0.001;  // [1] sine
constexpr std::size_t kSpacingBins = 256;

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

/// [rad] Median angle between the beams of neighbouring points, give or take a bin; 0 without neighbours.
double beamSpacing(std::span<const ScanPoint> points, const Eigen::Vector2d& lidar) {
  std::array<int, kSpacingBins> counts{};
  int count = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Eigen::Vector2d a = points[i - 1].position - lidar, b = points[i].position - lidar;
    const double sine = std::abs(a.x() * b.y() - a.y() * b.x()) / std::sqrt(a.squaredNorm() * b.squaredNorm());
    if (!(a.dot(b) > 0.0)) continue;  // half a turn was not seen
    ++counts[std::min<std::size_t>(kSpacingBins - 1, static_cast<std::size_t>(sine / kSpacingBin))];
    ++count;
  }
  int below = 0;
  for (std::size_t bin = 0; bin < kSpacingBins && count > 0; ++bin) {
    below += counts[bin];
    if (2 * below >= count) return (static_cast<double>(bin) + 0.5) * kSpacingBin;
  }
  return 0.0;
}

/// Whether three points seen from the origin lie on one line, as far as their ranges and bearings tell: along a line
/// the inverse of the range is a sine of the bearing. Far along a wall a beam that is off by a tenth of a degree meets
/// it decimetres away.
bool inARow(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const NormalConfig& config) {
  const Eigen::Array3d inverse_ranges = 1.0 / Eigen::Array3d(a.norm(), b.norm(), c.norm());
  const auto sine = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) { return p.x() * q.y() - p.y() * q.x(); };
  const Eigen::Array3d sines(sine(b, c), sine(c, a), sine(a, b));
  if (!(sines[0] * sines[2] > 0.0)) return false;
  const Eigen::Array3d terms = sines * inverse_ranges.prod();  // sine between two beams by the third one's range
  const Eigen::Array3d turned(inverse_ranges[1] - inverse_ranges[2], inverse_ranges[2] - inverse_ranges[0],
                              inverse_ranges[0] - inverse_ranges[1]);  // the sum's slope by each bearing
  const double sigma = std::hypot(config.range_sigma * (terms * inverse_ranges).matrix().norm(),
                                  config.bearing_sigma * turned.matrix().norm());
  return std::abs(terms.sum()) < config.in_a_row * sigma;
}

/// Whether a point goes on a row that comes from one side: the next two there, the first of them nearer and far off.
bool continues(const ScanPoints& points, std::size_t index, int step, double max_gap, const Eigen::Vector2d& lidar,
               const NormalConfig& config) {
  const auto size = static_cast<std::ptrdiff_t>(points.size()), i = static_cast<std::ptrdiff_t>(index);
  const std::ptrdiff_t last = i + 2 * step;
  if (last < 0 || last >= size) return false;
  const ScanPoint &point = points[index], &next = points[static_cast<std::size_t>(i + step)];
  const Eigen::Vector2d &p = point.position, &q = next.position;
  return next.range < point.range && (q - p).squaredNorm() > max_gap * max_gap &&
         inARow(p - lidar, q - lidar, points[static_cast<std::size_t>(last)].position - lidar, config);
}

}  // namespace

double relativeSpacing(std::span<const ScanPoint> points, const Eigen::Vector2d& lidar, const NormalConfig& config) {
  return std::max(1.0, beamSpacing(points, lidar) / config.fine_spacing);
}

double estimateNormals(ScanPoints& points, const Eigen::Vector2d& lidar, const NormalConfig& config) {
  const double relative_spacing = relativeSpacing(points, lidar, config);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ScanPoint& point = points[i];
    point.normal.setZero();
    point.grazing = false;
    const double max_gap = std::max(config.max_gap, relative_spacing * config.max_gap_per_range * point.range);
    Moments m;
    addSide(points, i, -1, max_gap, config, m);
    addSide(points, i, +1, max_gap, config, m);
    if (m.n < 1.0 + config.min_neighbours) {
      point.grazing =
          continues(points, i, -1, max_gap, lidar, config) || continues(points, i, +1, max_gap, lidar, config);
      continue;
    }

    const double sxx = m.xx - m.x * m.x / m.n, sxy = m.xy - m.x * m.y / m.n, syy = m.yy - m.y * m.y / m.n;
    const double spread = std::sqrt((sxx - syy) * (sxx - syy) + 4.0 * sxy * sxy);
    const double along = 0.5 * (sxx + syy + spread), across = std::max(0.0, 0.5 * (sxx + syy - spread));
    if (across / m.n > config.max_line_error * config.max_line_error || along < 8.0 * across) continue;
    const double variance = std::max(config.range_sigma * config.range_sigma, across / (m.n - 2.0 + 1e-9)) / along;
    if (!(variance < 0.15)) continue;  // more than 22 degrees: it says nothing

    // Across the principal axis, whose angle has the tangent 2 sxy / (spread + sxx - syy): of the two forms the one
    // that does not subtract.
    Eigen::Vector2d normal =
        sxx > syy ? Eigen::Vector2d(-2.0 * sxy, spread + sxx - syy) : Eigen::Vector2d(-(spread + syy - sxx), 2.0 * sxy);
    normal.normalize();
    if (normal.dot(lidar - point.position) < 0.0) normal = -normal;
    point.normal = normal;
    point.normal_variance = variance;
  }
  return relative_spacing;
}

}  // namespace slam
