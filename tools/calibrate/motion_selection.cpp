// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/motion_selection.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

namespace slam {
namespace {

AccumulatedAngles interpolate(const AccumulatedAngles& from, const AccumulatedAngles& to, Timestamp stamp) {
  const double fraction = toSeconds(stamp - from.stamp) / toSeconds(to.stamp - from.stamp);
  return {stamp, from.left + fraction * (to.left - from.left), from.right + fraction * (to.right - from.right)};
}

/// The wheels' steps from one stamp to the other.
/// @return std::nullopt where readings are missing or the counters began anew
std::optional<std::vector<WheelStep>> wheelsBetween(const std::vector<AccumulatedAngles>& wheels, Timestamp begin,
                                                    Timestamp end, const RobotGeometry& configured,
                                                    const MotionConfig& config) {
  const auto after = [&](Timestamp stamp) {
    return std::lower_bound(wheels.begin(), wheels.end(), stamp,
                            [](const AccumulatedAngles& reading, Timestamp t) { return reading.stamp < t; });
  };
  const auto first = after(begin), last = after(end);
  if (first == wheels.begin() || last == wheels.end()) return std::nullopt;
  for (auto reading = first; reading <= last; ++reading) {
    const double interval = toSeconds(reading->stamp - std::prev(reading)->stamp);
    const double left = configured.left_radius * (reading->left - std::prev(reading)->left);
    const double right = configured.right_radius * (reading->right - std::prev(reading)->right);
    if (interval > config.max_wheel_gap) return std::nullopt;
    if (std::max(std::abs(left), std::abs(right)) > config.max_wheel_speed * interval) return std::nullopt;
  }

  std::vector<AccumulatedAngles> path{interpolate(*std::prev(first), *first, begin)};
  path.insert(path.end(), first, last);
  path.push_back(interpolate(*std::prev(last), *last, end));
  std::vector<WheelStep> steps;
  for (std::size_t i = 1; i < path.size(); ++i) {
    steps.push_back({path[i].left - path[i - 1].left, path[i].right - path[i - 1].right});
  }
  return steps;
}

/// Motion of the lidar between two matched scans, whose errors are taken as independent.
LidarMotion lidarMotion(const MatchedScan& begin, const MatchedScan& end, const Pose2& T_base_lidar) {
  const Pose2 T_map_begin = begin.T_map_base * T_base_lidar, T_map_end = end.T_map_base * T_base_lidar;
  const BinaryJacobians relative = betweenJacobians(T_map_begin, T_map_end);
  const Eigen::Matrix3d J_begin = relative.first * composeJacobians(begin.T_map_base, T_base_lidar).first;
  const Eigen::Matrix3d J_end = relative.second * composeJacobians(end.T_map_base, T_base_lidar).first;
  return {between(T_map_begin, T_map_end),
          J_begin * begin.covariance * J_begin.transpose() + J_end * end.covariance * J_end.transpose(),
          {}};
}

bool positive(const Eigen::Matrix3d& covariance) {
  return covariance.allFinite() && covariance.llt().info() == Eigen::Success;
}

}  // namespace

std::vector<LidarMotion> selectMotions(const SensorLog& log, const RobotGeometry& configured,
                                       const MotionConfig& config) {
  std::vector<LidarMotion> motions;
  const MatchedScan* begin = nullptr;
  const MatchedScan* previous = nullptr;
  for (const MatchedScan& scan : log.scans) {
    const bool gap = previous != nullptr && toSeconds(scan.stamp - previous->stamp) > config.max_scan_gap;
    const bool slow = begin != nullptr && toSeconds(scan.stamp - begin->stamp) > config.max_time;
    previous = &scan;
    if (begin == nullptr || gap || slow) {
      begin = &scan;
      continue;
    }
    auto wheels = wheelsBetween(log.wheels, begin->stamp, scan.stamp, configured, config);
    if (wheels) {
      const Pose2 moved = predictPose(configured, *wheels);
      if (moved.translation().norm() < config.translation && std::abs(moved.theta) < config.rotation) continue;
      LidarMotion motion = lidarMotion(*begin, scan, configured.T_base_lidar);
      motion.wheels = *std::move(wheels);
      if (positive(motion.covariance)) motions.push_back(std::move(motion));
    }
    begin = &scan;
  }
  return motions;
}

}  // namespace slam
