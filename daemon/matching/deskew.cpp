// SPDX-License-Identifier: BSD-3-Clause
#include "matching/deskew.hpp"

#include <cmath>

namespace slam {
namespace {

/// Walks along the history with the beams' times: they rarely go back, so the search is a step, not a bisection.
class MotionSince {
 public:
  MotionSince(const PoseHistory& history, Timestamp stamp)
      : history_(history), T_stamp_w_(history.at(stamp, Duration::max()).value_or(Pose2{}).inverse()) {}

  /// @return T_base(stamp)_base(t)
  Pose2 at(Timestamp t) {
    if (history_.size() < 2) return {};
    while (i_ + 2 < history_.size() && history_[i_ + 1].stamp <= t) ++i_;
    while (i_ > 0 && history_[i_].stamp > t) --i_;
    if (i_ != cached_) {
      from_ = T_stamp_w_ * history_[i_].pose;
      to_ = T_stamp_w_ * history_[i_ + 1].pose;
      turn_ = wrapAngle(to_.theta - from_.theta);
      interval_ = toSeconds(history_[i_ + 1].stamp - history_[i_].stamp);
      cached_ = i_;
    }
    // Linear within one interval of the history (5-20 ms): the arc's sagitta is below 0.1 mm at 1 m/s and 2 rad/s.
    const double f = toSeconds(t - history_[i_].stamp) / interval_;
    return {from_.x + f * (to_.x - from_.x), from_.y + f * (to_.y - from_.y), from_.theta + f * turn_};
  }

 private:
  const PoseHistory& history_;
  Pose2 T_stamp_w_;
  std::size_t i_ = 0, cached_ = static_cast<std::size_t>(-1);
  Pose2 from_, to_;
  double turn_ = 0.0, interval_ = 1.0;
};

}  // namespace

void deskew(const LaserScan& scan, const RangeLimits& limits, Timestamp stamp, const LidarMounting& mounting,
            const PoseHistory& history, ScanPoints& points, BearingTable* bearings) {
  points.clear();
  MotionSince motion(history, stamp);
  const PointTransform T_base_lidar(mounting.T_base_lidar);
  const double side = mounting.upside_down ? -1.0 : 1.0;
  std::size_t index = 0;
  for (const Beam& beam : scan.beams()) {
    const std::size_t i = index++;
    if (!limits.contains(beam.range) || !std::isfinite(beam.bearing)) continue;
    const Eigen::Vector2d direction =
        bearings != nullptr ? bearings->direction(i, beam.bearing) : BearingTable::computed(beam.bearing);
    const Eigen::Vector2d p_lidar(beam.range * direction.x(), side * beam.range * direction.y());
    Eigen::Vector2d p_base = T_base_lidar * p_lidar;
    if (beam.time_offset != 0.0F) p_base = motion.at(stamp + fromSeconds(beam.time_offset)) * p_base;
    points.push_back({.position = p_base, .bearing = wrapAngle(side * beam.bearing), .range = beam.range});
  }
}

}  // namespace slam
