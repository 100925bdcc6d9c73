// SPDX-License-Identifier: BSD-3-Clause
#include "matching/range_image.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/pose2.hpp"

namespace slam {

/// The bins from one bearing to another [rad].
template <typename Visit>
void RangeImage::forBins(double from, double to, Visit visit) const {
  const double per_bin = kBins / (2.0 * std::numbers::pi);
  const int turns = 2 * kBins;  // added, so that truncation rounds down
  const int first = static_cast<int>(from * per_bin + turns), last = static_cast<int>(to * per_bin + turns);
  for (int bin = first, place = first % kBins; bin <= last; ++bin, place = place + 1 < kBins ? place + 1 : 0) {
    if (!visit(static_cast<std::size_t>(place))) return;
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
      forBins(first, first + std::abs(gap), [&](std::size_t bin) {
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
  forBins(bearing - gap, bearing + gap, [&](std::size_t bin) {
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
  // In single precision, which is a thousandth of a bin.
  const float bearing = std::atan2(static_cast<float>(way.y()), static_cast<float>(way.x()));
  const auto error = static_cast<float>(config_.bearing_error + std::min(1.0, config_.place_error / distance));
  const auto nearest = static_cast<float>(distance - config_.margin),
             beyond = static_cast<float>(distance + config_.margin);
  // Where the lidar itself is there is nothing else, unless it is seen.
  const Visibility unseen = nearest < 0.0F ? Visibility::kViolated : Visibility::kUnknown;
  Visibility sight = Visibility::kViolated;
  forBins(bearing - error, bearing + error, [&](std::size_t bin) {
    const float range = ranges_[bin];
    if (range == 0.0F) sight = unseen;
    if (range > 0.0F && range > nearest && range < beyond) sight = Visibility::kConsistent;
    if (range > 0.0F && range <= nearest) sight = Visibility::kOccluded;
    return sight == Visibility::kViolated || sight == Visibility::kOccluded;
  });
  return sight;
}

}  // namespace slam
