// SPDX-License-Identifier: BSD-3-Clause
#include "graph/keyframe_graph.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/pose_covariance.hpp"

namespace slam {

Keyframe::Point keyframePoint(const ScanPoint& point) {
  Keyframe::Point out{.x = static_cast<float>(point.position.x()), .y = static_cast<float>(point.position.y())};
  if (!point.hasNormal()) {
    out.normal_sigma = point.grazing ? Keyframe::Point::kGrazing : 0;
    return out;
  }
  const double units = 1.0 / Keyframe::Point::kAngle;
  out.normal = static_cast<std::int16_t>(std::lround(units * std::atan2(point.normal.y(), point.normal.x())));
  out.normal_sigma =
      static_cast<std::uint16_t>(std::min(65535.0, std::round(units * std::sqrt(point.normal_variance))));
  return out;
}

ScanPoint scanPoint(const Keyframe::Point& point, const Pose2& T_base_lidar) {
  const Eigen::Vector2d position(point.x, point.y), seen = position - T_base_lidar.translation();
  ScanPoint out{.position = position,
                .beam = seen.normalized(),
                .bearing = wrapAngle(std::atan2(seen.y(), seen.x()) - T_base_lidar.theta),
                .range = seen.norm()};
  if (point.normal == Keyframe::Point::kNoNormal) {
    out.grazing = point.normal_sigma == Keyframe::Point::kGrazing;
    return out;
  }
  const double angle = point.normal * Keyframe::Point::kAngle, sigma = point.normal_sigma * Keyframe::Point::kAngle;
  out.normal = {std::cos(angle), std::sin(angle)};
  out.normal_variance = sigma * sigma;
  return out;
}

void KeyframeGraph::add(const Keyframe& keyframe) {
  const int id = size();
  const Pose2 T_map_base = id == 0 ? keyframe.T_map_base : pose(id - 1) * keyframe.T_previous_base;
  add(std::make_shared<const StoredScan>(keyframe), T_map_base);
  if (id == 0) return;
  graph_.addEdge({.from = id - 1,
                  .to = id,
                  .T_from_to = keyframe.T_previous_base,
                  .information = rotated(keyframe.step_covariance.inverse(), -keyframe.T_previous_base.theta),
                  .kind = EdgeKind::kMotion});
}

void KeyframeGraph::add(std::shared_ptr<const StoredScan> scan, const Pose2& T_map_base) {
  graph_.addNode(T_map_base);
  scans_.push_back(std::move(scan));
}

void KeyframeGraph::points(int id, ScanPoints& points) const {
  const StoredScan& stored = *scan(id);
  points.clear();
  for (const Keyframe::Point& point : stored.points) points.push_back(scanPoint(point, stored.T_base_lidar));
  const bool is_picture = !stored.free.empty() || !stored.solid.empty();  // which no lidar has drawn
  if (is_picture)
    for (ScanPoint& point : points) point.beam.setZero();
}

void KeyframeGraph::gather(int newest, int oldest, double length, int limit, ScanPoints& points) const {
  points.clear();
  const Pose2 T_newest_map = pose(newest).inverse();
  double path = 0.0;
  for (int id = newest; id >= oldest; --id) {
    if (id < newest) path += (pose(id).translation() - pose(id + 1).translation()).norm();
    if (path > length) break;
    this->points(id, scratch_);
    const PointTransform T_newest_id(T_newest_map * pose(id));
    for (ScanPoint point : scratch_) {
      point.position = T_newest_id * point.position;
      point.normal = T_newest_id.turned(point.normal);
      point.beam = T_newest_id.turned(point.beam);
      points.push_back(point);
    }
  }
  const auto most = static_cast<std::size_t>(limit);
  if (points.size() <= most) return;
  for (std::size_t i = 0; i < most; ++i) points[i] = points[i * points.size() / most];
  points.resize(most);
}

std::shared_ptr<const StoredScan> scanWithout(const std::shared_ptr<const StoredScan>& scan, const BodyShape& body,
                                              double margin) {
  const PointTransform T_lidar_base(scan->T_base_lidar.inverse());
  auto rest = std::make_shared<StoredScan>(*scan);
  const auto left_out = std::erase_if(rest->points, [&](const Keyframe::Point& point) {
    return body.holds(T_lidar_base * Eigen::Vector2d(point.x, point.y), margin);
  });
  if (left_out == 0) return scan;
  return rest;
}

void KeyframeGraph::truncate(int count) {
  graph_.truncate(count);
  scans_.resize(static_cast<std::size_t>(count));
}

void KeyframeGraph::addTo(Reference& reference, std::span<const int> ids) const {
  for (const int id : ids) {
    points(id, scratch_);
    reference.add(pose(id), scratch_, turning(pose(id).theta) * scan(id)->sensitivity);
  }
}

}  // namespace slam
