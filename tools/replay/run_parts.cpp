// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/run_parts.hpp"

#include <algorithm>

#include "diagnostics/sensor_problems.hpp"

namespace slam {
namespace {

constexpr double kFewStuck = 5, kFewStuckShare = 0.01;  // scans of a stuck lidar, [1] of all: no more is no fault

std::optional<TrajectoryWriter> writerFor(const std::filesystem::path& file) {
  return file.empty() ? std::nullopt : std::optional<TrajectoryWriter>(file);
}

RangeLimits limitsOf(const LidarModel& lidar) {
  return {static_cast<float>(lidar.range_min), static_cast<float>(lidar.range_max)};
}

}  // namespace

RunPoses::RunPoses(const ReplayOptions& options, bool localise_only)
    : final_(writerFor(options.trajectory)),
      causal_(writerFor(options.causal)),
      odometry_(writerFor(options.odometry)),
      wheels_(writerFor(options.wheels)),
      localise_only_(localise_only) {}

void RunPoses::addWheels(std::int64_t utime, const Pose2& T_wheels_base) {
  if (wheels_) wheels_->write(utime, T_wheels_base);
}

void RunPoses::add(std::int64_t utime, const ScanEstimate& estimate, const FrontEnd& front_end) {
  // In a given map the pose is its own anchor.
  const Pose2& T_map_base = estimate.T_map_base;
  const AnchoredPose pose = localise_only_ ? AnchoredPose{-1, T_map_base} : front_end.anchor(T_map_base);
  rows_.push_back({utime, front_end.session(), pose.keyframe, pose.T_keyframe_base});
  if (causal_) causal_->write(utime, T_map_base);
  if (odometry_) odometry_->write(utime, estimate.T_odom_base);
}

void RunPoses::place(const Pose2& T_map_session, std::int32_t session) {
  if (!localise_only_) return;
  for (auto row = rows_.rbegin(); row != rows_.rend() && row->session == session; ++row)
    row->T_keyframe_base = T_map_session * row->T_keyframe_base;
}

void RunPoses::finish(const KeyframeGraph& keyframes) {
  for (const Row& row : rows_) {
    const Pose2 T_map_keyframe = row.keyframe < 0 ? Pose2{} : keyframes.pose(row.keyframe);
    if (final_) final_->write(row.utime, T_map_keyframe * row.T_keyframe_base);
  }
  for (auto* writer : {&final_, &causal_, &odometry_, &wheels_}) {
    if (*writer) (*writer)->close();
  }
}

void RunFrames::add(const LaserScan& scan, Timestamp stamp, double log_s, Pipeline& pipeline) {
  const LidarModel& lidar = pipeline.frontEnd().config().lidar;
  PoseHistory motion(2);
  const Timestamp end = stamp + (scan.size > 0 ? fromSeconds(scan.beams().back().time_offset) : Duration(0));
  for (const Timestamp t : {stamp, end}) motion.push(t, pipeline.frontEnd().odometry(t).T_odom_base);
  deskew(scan, limitsOf(lidar), stamp, lidar.mounting(), motion, points_);
  seen_.clear();
  for (const ScanPoint& point : points_) seen_.push_back(point.position);
  stamp_ = stamp;
  if (viewer_.due(log_s)) draw(log_s, pipeline);
}

void RunFrames::finish(double log_s, Pipeline& pipeline) {
  draw(log_s, pipeline);
  viewer_.close();
}

void RunFrames::draw(double log_s, Pipeline& pipeline) {
  const PoseGraph& graph = pipeline.backEnd().keyframes().graph();
  viewer_.write(renderMap(pipeline.drawn().grid()), {.log_s = log_s,
                                                     .T_map_base = pipeline.frontEnd().estimate(stamp_).T_map_base,
                                                     .scan = seen_,
                                                     .keyframes = graph.poses(),
                                                     .edges = graph.edges()});
}

void LidarWatch::add(const LaserScan& scan, const LidarModel& lidar) {
  echoes_.add(scan, limitsOf(lidar), scan.stamp);
  if (echoes_.finding() == EchoWatch::Finding::kNone) return;
  finding_ = echoes_.finding();
  ++blind_;
}

void LidarWatch::warn(ReplayStats& stats) const {
  if (stuck_ > std::max(kFewStuck, kFewStuckShare * stats.front_end.scans)) {
    stats.warnings.push_back("the lidar was stuck: " + std::to_string(stuck_) +
                             " scans show the ranges of the turn before although the robot moves; they were left out; "
                             "look after its cable and power");
  }
  if (blind_ > 0)
    stats.warnings.push_back("lidar: " + std::to_string(blind_) + " scans with " + problemOf(finding_).words());
}

}  // namespace slam
