// SPDX-License-Identifier: BSD-3-Clause
#include "matching/range_image.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/pose2.hpp"

namespace slam {

float roughBearing(float x, float y) {
  // Abramowitz and Stegun 4.4.49, of one octant.
  const float ax = std::abs(x), ay = std::abs(y), t = std::min(ax, ay) / std::max(ax, ay), tt = t * t;
  const float first_octant =
      t * (0.9998660F + tt * (-0.3302995F + tt * (0.1801410F + tt * (-0.0851330F + tt * 0.0208351F))));
  const float first_quadrant = ay > ax ? 0.5F * std::numbers::pi_v<float> - first_octant : first_octant;
  return std::copysign(x < 0.0F ? std::numbers::pi_v<float> - first_quadrant : first_quadrant, y);
}

/// The bins from one bearing to another [rad].
RangeImage::Bins RangeImage::binsOf(double from, double to) {
  return {static_cast<int>(from * kPerRadian + kTurns), static_cast<int>(to * kPerRadian + kTurns)};
}

/// The bins within `error` [rad] of where a point lies. @param way [m] from the lidar
RangeImage::Bins RangeImage::binsAround(const Eigen::Vector2d& way, float error) {
  // In single precision, which is a thousandth of a bin.
  const auto x = static_cast<float>(way.x()), y = static_cast<float>(way.y());
  // The rough bearing is enough where no bin's border is near: of what is added to it, rounding is a tenth.
  const float rough = roughBearing(x, y);
  constexpr auto border = static_cast<float>(2.0 * kRoughBearingError * kPerRadian);  // [bins]
  const float from = (rough - error) * static_cast<float>(kPerRadian) + kTurns,
              to = (rough + error) * static_cast<float>(kPerRadian) + kTurns;
  const Bins bins{static_cast<int>(from - border), static_cast<int>(to - border)};
  if (std::isfinite(rough) && bins.first == static_cast<int>(from + border) &&
      bins.last == static_cast<int>(to + border))
    return bins;
  const float bearing = std::atan2(y, x);
  return binsOf(bearing - error, bearing + error);
}

template <typename Visit>
void RangeImage::forBins(const Bins& bins, Visit visit) const {
  for (int bin = bins.first, at = bin % kBins; bin <= bins.last; ++bin, at = at + 1 < kBins ? at + 1 : 0) {
    if (!visit(static_cast<std::size_t>(at))) return;
  }
}

void RangeImage::set(std::span<const ScanPoint> points, const Eigen::Vector2d& lidar) {
  ranges_.fill(0.0F);
  lidar_ = lidar;
  farthest_ = 0.0F;
  if (points.empty()) return;
  Eigen::Vector2d beam = points.back().position - lidar;  // the neighbour of the first after a whole turn
  double last_bearing = std::atan2(beam.y(), beam.x());
  auto last_range = static_cast<float>(beam.norm());
  for (const ScanPoint& point : points) {
    beam = point.position - lidar;
    const double bearing = std::atan2(beam.y(), beam.x());
    const auto range = static_cast<float>(beam.norm());
    farthest_ = std::max(farthest_, range);
    const double gap = wrapAngle(bearing - last_bearing);
    if (std::abs(gap) < config_.max_gap) {
      const float nearer = std::min(range, last_range);
      const double first = last_bearing + std::min(0.0, gap);
      forBins(binsOf(first, first + std::abs(gap)), [&](std::size_t bin) {
        ranges_[bin] = ranges_[bin] > 0.0F ? std::min(ranges_[bin], nearer) : nearer;
        return true;
      });
    }
    last_bearing = bearing;
    last_range = range;
  }
}

void RangeImage::setOpen(double bearing, double gap, double range) {
  if (gap >= config_.max_gap) return;
  const auto free = static_cast<float>(range);
  forBins(binsOf(bearing - gap, bearing + gap), [&](std::size_t bin) {
    if (ranges_[bin] == 0.0F) ranges_[bin] = free;
    return true;
  });
  farthest_ = std::max(farthest_, free);
}

RangeImage::Visibility RangeImage::visibilityOf(const Eigen::Vector2d& p, const Eigen::Vector2d& normal) const {
  const Eigen::Vector2d way = p - lidar_;
  const double distance = way.norm();
  if (distance > farthest_ + config_.margin) return Visibility::kUnknown;
  if (!normal.isZero() && std::abs(normal.dot(way)) < config_.grazing * distance) return Visibility::kUnknown;
  const auto error = static_cast<float>(config_.bearing_error + std::min(1.0, config_.place_error / distance));
  const auto nearest = static_cast<float>(distance - config_.margin),
             beyond = static_cast<float>(distance + config_.margin);
  // Where the lidar itself is there is nothing else, unless it is seen.
  const Visibility unseen = nearest < 0.0F ? Visibility::kViolated : Visibility::kUnknown;
  Visibility sight = Visibility::kViolated;
  forBins(binsAround(way, error), [&](std::size_t bin) {
    const float range = ranges_[bin];
    if (range == 0.0F) sight = unseen;
    if (range > 0.0F && range > nearest && range < beyond) sight = Visibility::kConsistent;
    if (range > 0.0F && range <= nearest) sight = Visibility::kOccluded;
    return sight == Visibility::kViolated || sight == Visibility::kOccluded;
  });
  return sight;
}

}  // namespace slam
