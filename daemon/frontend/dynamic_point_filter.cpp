// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/dynamic_point_filter.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

/// Cosine of the angle at which a beam from the lidar to p meets a line there.
double squareness(const Eigen::Vector2d& p, const Eigen::Vector2d& normal, const Eigen::Vector2d& lidar) {
  return std::abs(normal.dot((p - lidar).normalized()));
}

}  // namespace

DynamicPointFilter::DynamicPointFilter(const LidarMounting& lidar, const DynamicPointFilterConfig& config)
    : lidar_(lidar), config_(config) {}

void DynamicPointFilter::apply(ScanPoints& points, Timestamp stamp, const EkfTimeline& filter,
                               std::span<const Beam> beams, std::span<const bool> open, double reach) {
  const Pose2 T_last_base = follow(stamp, filter);
  if (count_ == 0 || (earlier_[0].T_earlier_base * T_last_base).translation().norm() > config_.spacing)
    remember(points, stamp, beams, open, reach);

  walls_ = {};
  if (count_ < 2) return;

  const Eigen::Vector2d lidar = lidar_.T_base_lidar.translation();
  VisibilityTally tally;
  through_.reset();
  std::fill_n(votes_.begin(), points.size(), std::int8_t{0});
  for (std::size_t k = 1; k < count_; ++k) {
    const EarlierScan& earlier = earlier_[k];
    const PointTransform T_earlier_base(earlier.T_earlier_base * T_last_base);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d place = T_earlier_base * points[i].position;
      const Eigen::Vector2d normal = T_earlier_base.turned(points[i].normal);
      const auto sight = earlier.image.visibilityOf(place, normal);
      const bool consistent = sight == RangeImage::Visibility::kConsistent;
      if (!consistent && sight != RangeImage::Visibility::kViolated) continue;
      tally.add(sight);
      // Glass sends back what meets it squarely, and is looked through at any other angle.
      const bool is_wall = points[i].hasNormal() &&
                           squareness(place, normal, lidar) >= squareness(points[i].position, points[i].normal, lidar);
      if (is_wall) walls_.add(sight);
      const bool violated = !consistent && (place - lidar).norm() < earlier.sharp;
      if (violated) through_.set(i);
      votes_[i] = static_cast<std::int8_t>(votes_[i] + violated - consistent);
    }
  }
  if (tally.freeSpaceViolation() >= config_.most) return;
  const auto moved = [this](std::size_t i) { return through_.test(i) && votes_[i] >= 0; };
  std::size_t left = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool beside = (i > 0 && moved(i - 1)) || (i + 1 < points.size() && moved(i + 1));
    if (!moved(i) || !beside) points[left++] = points[i];  // one alone is noise of its range
  }
  points.resize(left);
}

/// @return base at the stamp, seen from base at the last scan
Pose2 DynamicPointFilter::follow(Timestamp stamp, const EkfTimeline& filter) {
  const auto begin = last_;
  last_ = stamp;
  if (count_ == 0) return {};
  const Timestamp before = earlier_[count_ - 1].stamp;  // of the scan before the last, unless that is the only one
  if (stamp < *begin || before < filter.oldestStamp()) {
    count_ = 0;
    return {};
  }
  const Pose2 last = filter.poseAt(*begin);
  const Pose2 T_before_last = between(filter.poseAt(before), last);
  for (EarlierScan& earlier : std::span(earlier_).first(count_)) {
    if (earlier.stamp == before) earlier.T_earlier_base = earlier.T_earlier_base * T_before_last;
    earlier.stamp = *begin;
  }
  return between(last, filter.poseAt(stamp));
}

void DynamicPointFilter::remember(const ScanPoints& points, Timestamp stamp, std::span<const Beam> beams,
                                  std::span<const bool> open, double reach) {
  std::shift_right(earlier_.begin(), earlier_.end(), 1);
  count_ = std::min(count_ + 1, earlier_.size());
  EarlierScan& now = earlier_[0];
  now.T_earlier_base = {};
  now.stamp = stamp;
  now.image.set(points, lidar_.T_base_lidar.translation());
  double turn = 0.0;  // [rad]
  for (std::size_t i = 1; i < beams.size(); ++i) {
    const double gap = std::abs(wrapAngle(beams[i].bearing - beams[i - 1].bearing));
    turn += gap;
    if (!open[i]) continue;
    const double bearing = lidar_.T_base_lidar.theta + (lidar_.upside_down ? -1.0 : 1.0) * beams[i].bearing;
    now.image.setOpen(bearing, gap, config_.open * reach);
  }
  now.sharp = turn > 0.0 ? config_.width * static_cast<double>(beams.size()) / turn : 0.0;
}

}  // namespace slam
