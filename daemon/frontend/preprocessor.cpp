// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/preprocessor.hpp"

#include <algorithm>

namespace slam {
namespace {

constexpr std::size_t kHistoryCapacity = 1024;  // poses within one scan

/// When the beams were sampled, in any order and on either side of the scan's stamp.
struct Sweep {
  Timestamp begin, end;
};

Sweep sweepOf(const LaserScan& scan, Timestamp stamp) {
  float first = 0.0F, last = 0.0F;  // [s]
  for (const Beam& beam : scan.beams()) {
    first = std::min(first, beam.time_offset);
    last = std::max(last, beam.time_offset);
  }
  return {stamp + fromSeconds(first), stamp + fromSeconds(last)};
}

}  // namespace

Preprocessor::Preprocessor(const PreprocessorConfig& config, const LidarModel& lidar, const MatchConfig& match,
                           const BodyShape& body)
    : interpreter_(config.interpreter, lidar, body),
      lidar_(lidar),
      normals_(config.normals),
      scan_moment_(config.scan_moment),
      point_weight_(match.point_weight),
      dynamic_points_(lidar_.mounting(), config.dynamic_points),
      history_(kHistoryCapacity) {
  cloud_.match = match;
  cloud_.points.reserve(LaserScan::kCapacity);
}

/// What the filter is wrong about the speed moves the beams before the middle one way and those behind it the other, so
/// that the pose found there is right. At the first beam's time it would be wrong by half of the turn's error, the next
/// speed by as much the other way, and so on without end.
const Cloud& Preprocessor::process(const LaserScan& recorded, Timestamp first, double interval,
                                   const EkfTimeline& filter, const EkfTimeline& odometry) {
  const LaserScan& scan = interpreter_.interpret(recorded, first, interval, odometry);
  cloud_.scan = &scan;
  cloud_.body = interpreter_.leftOut();
  const Sweep sweep = sweepOf(scan, first);
  cloud_.stamp = sweep.begin + std::chrono::duration_cast<Duration>(scan_moment_ * (sweep.end - sweep.begin));
  filter.fillHistory(sweep.begin, sweep.end, history_);
  deskew(scan, lidar_.limitsFor(scan), first, lidar_.mounting(), history_, cloud_.points, &bearings_);
  cloud_.T_base_first = {};
  if (sweep.end > sweep.begin) {
    const auto at = [this](Timestamp stamp) { return history_.at(stamp, Duration::max()).value_or(Pose2{}); };
    cloud_.T_base_first = between(at(cloud_.stamp), at(first));
    for (ScanPoint& point : cloud_.points) point.position = cloud_.T_base_first * point.position;
  }
  const Eigen::Vector2d lidar = lidar_.T_base_lidar.translation();
  for (ScanPoint& point : cloud_.points) point.beam = (point.position - lidar).normalized();
  const double relative_spacing = estimateNormals(cloud_.points, lidar, normals_);
  dynamic_points_.apply(cloud_.points, cloud_.stamp, filter, scan.beams(), interpreter_.open(),
                        lidar_.limitsFor(scan).max);
  cloud_.walls = dynamic_points_.walls();
  // Where beams lie far apart, a point on no line is a wall that was hit once: its partner tells little of the way.
  cloud_.match.point_weight = point_weight_ / relative_spacing;
  return cloud_;
}

}  // namespace slam
