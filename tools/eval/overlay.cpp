// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/overlay.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "matching/deskew.hpp"
#include "matching/normals.hpp"
#include "matching/reference.hpp"

namespace slam {
namespace {

struct PlacedStamp {
  Timestamp stamp;
  Pose2 T_map_base;
};

/// Calls visit(scan) for each scan of the log, in its order.
template <typename Visit>
void forEachScan(const std::filesystem::path& log, Visit&& visit) {
  EventLogReader reader(log);
  for (LogEvent event; reader.next(event);) {
    if (event.channel != channel::kScan) continue;
    const auto message = decodeChecked<scan_t>(event.data);
    const auto scan = message ? fromMessage(*message) : std::nullopt;
    if (scan) visit(*scan);
  }
}

/// Which scans belong to the two visits: [0, first) and [last_begin, last_end).
struct Visits {
  std::size_t first = 0, last_begin = 0, last_end = 0;
};

Visits findVisits(const std::vector<PlacedStamp>& scans, const OverlayOptions& options) {
  const PlacedStamp& start = scans.front();
  const auto near = [&](const PlacedStamp& scan) {
    const Pose2 apart = between(start.T_map_base, scan.T_map_base);
    return std::hypot(apart.x, apart.y) < options.distance && std::abs(apart.theta) < options.rotation;
  };
  const Timestamp half = start.stamp + (scans.back().stamp - start.stamp) / 2;
  Visits visits;
  while (visits.first < scans.size() && near(scans[visits.first]) &&
         toSeconds(scans[visits.first].stamp - start.stamp) < options.first_seconds) {
    ++visits.first;
  }
  const auto left = std::find_if_not(scans.begin(), scans.end(), near);
  if (left == scans.end()) throw std::runtime_error("the robot never leaves its start: there is no second visit");
  const auto earliest = std::find_if(left, scans.end(), [&](const PlacedStamp& scan) { return scan.stamp >= half; });
  visits.last_end = scans.size();
  const auto first_allowed = static_cast<std::size_t>(earliest - scans.begin());
  while (visits.last_end > first_allowed && !near(scans[visits.last_end - 1])) --visits.last_end;
  visits.last_begin = visits.last_end;
  while (visits.last_begin > first_allowed && near(scans[visits.last_begin - 1])) --visits.last_begin;
  if (visits.last_begin == visits.last_end) {
    throw std::runtime_error("the robot does not come back to its start in the second half of the log");
  }
  return visits;
}

}  // namespace

OverlayErrors overlayVisits(const Trajectory& trajectory, const std::filesystem::path& log, const Config& config,
                            const OverlayOptions& options) {
  std::vector<PlacedStamp> placed;
  forEachScan(log, [&](const LaserScan& scan) {
    if (const auto pose = poseAt(trajectory, scan.stamp)) placed.push_back({scan.stamp, *pose});
  });
  if (placed.empty()) throw std::runtime_error("no scan of the log lies within the trajectory's time");
  const Visits visits = findVisits(placed, options);

  const LidarModel& lidar = config.front_end.lidar;
  NormalConfig normals = config.front_end.preprocessor.normals;
  normals.range_sigma = lidar.range_sigma;
  ReferenceConfig walls = config.front_end.reference;
  walls.fine_radius = std::max(walls.fine_radius, options.pair_distance + walls.fine_cell);
  Reference reference(walls);
  reference.clear(placed.front().T_map_base.translation());

  OverlayErrors errors;
  errors.first_scans = static_cast<int>(visits.first);
  errors.last_scans = static_cast<int>(visits.last_end - visits.last_begin);
  double sum = 0.0;
  int pairs = 0;
  std::size_t at = 0;
  ScanPoints points;
  PoseHistory motion(2);
  forEachScan(log, [&](const LaserScan& scan) {
    const auto pose = poseAt(trajectory, scan.stamp);
    if (!pose) return;
    const std::size_t index = at++;
    const bool first = index < visits.first, last = index >= visits.last_begin && index < visits.last_end;
    if (!first && !last) return;
    const double turn = scan.size > 0 ? scan.beams().back().time_offset : 0.0;
    const Timestamp end = scan.stamp + fromSeconds(turn);
    motion.clear();
    motion.push(scan.stamp, *pose);
    if (const auto at_end = poseAt(trajectory, end, Duration(0))) motion.push(end, *at_end);
    deskew(scan, {static_cast<float>(lidar.range_min), static_cast<float>(lidar.range_max)}, scan.stamp,
           lidar.mounting(), motion, points);
    if (first) {
      estimateNormals(points, lidar.T_base_lidar.translation(), normals);
      reference.add(*pose, points);
      return;
    }
    for (const ScanPoint& point : points) {
      ++errors.points;
      const Eigen::Vector2d p = *pose * point.position;
      const Surfel* wall = reference.nearest(p, options.pair_distance);
      if (wall == nullptr || !wall->isLine()) continue;
      const Eigen::Vector2d from_wall = p - Eigen::Vector2d(wall->x, wall->y);
      if (from_wall.norm() > options.pair_distance) continue;
      sum += std::abs(from_wall.dot(Eigen::Vector2d(wall->nx, wall->ny)));
      ++pairs;
    }
  });
  if (pairs == 0) throw std::runtime_error("no point of the last visit lies near a wall of the first");
  errors.mean = sum / pairs;
  errors.paired = static_cast<double>(pairs) / errors.points;
  return errors;
}

}  // namespace slam
