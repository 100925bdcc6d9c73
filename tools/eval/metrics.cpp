// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/metrics.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace slam {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

MeanAndDeviation ofSquares(std::vector<double> values) {
  for (double& value : values) value *= value;
  return meanAndDeviation(values);
}

}  // namespace

MeanAndDeviation meanAndDeviation(const std::vector<double>& values) {
  MeanAndDeviation result;
  if (values.empty()) return result;
  for (const double value : values) result.mean += value;
  result.mean /= static_cast<double>(values.size());
  for (const double value : values) result.deviation += (value - result.mean) * (value - result.mean);
  result.deviation = std::sqrt(result.deviation / static_cast<double>(values.size()));
  return result;
}

std::vector<Relation> readRelations(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": cannot read: " + std::strerror(errno));
  std::vector<Relation> relations;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.empty() || line[0] == '#') continue;
    long double t1 = 0, t2 = 0;
    double x, y, z, roll, pitch, yaw;
    std::istringstream row(line);
    const bool eight = static_cast<bool>(row >> t1 >> t2 >> x >> y >> z >> roll >> pitch >> yaw);
    const auto from = stampOf(t1), to = stampOf(t2);
    if (!eight || !from || !to) {
      throw std::runtime_error(file.string() + ":" + std::to_string(number) +
                               ": not a relation; expected 't1 t2 x y z roll pitch yaw'");
    }
    relations.push_back({*from, *to, {x, y, yaw}});
  }
  if (relations.empty()) throw std::runtime_error(file.string() + ": no relation in it");
  return relations;
}

RelationErrors relationErrors(const Trajectory& trajectory, const std::vector<Relation>& relations) {
  RelationErrors errors;
  std::vector<double> translation, rotation;
  for (const Relation& relation : relations) {
    const auto from = poseAt(trajectory, relation.from), to = poseAt(trajectory, relation.to);
    if (!from || !to) {
      ++errors.left_out;
      continue;
    }
    const Pose2 error = between(relation.T_from_to, between(*from, *to));
    translation.push_back(std::hypot(error.x, error.y));
    rotation.push_back(std::abs(error.theta) * kDegrees);
  }
  errors.used = static_cast<int>(translation.size());
  errors.translation = meanAndDeviation(translation);
  errors.rotation = meanAndDeviation(rotation);
  errors.squared_translation = ofSquares(translation);
  errors.squared_rotation = ofSquares(rotation);
  return errors;
}

WaypointErrors waypointErrors(const Trajectory& estimate, const Trajectory& waypoints) {
  WaypointErrors errors;
  for (const StampedPose& waypoint : waypoints) {
    const auto pose = poseAt(estimate, waypoint.stamp);
    if (!pose) {
      ++errors.left_out;
      continue;
    }
    const Pose2 error = between(waypoint.pose, *pose);
    errors.position.push_back(std::hypot(error.x, error.y));
    errors.heading.push_back(std::abs(error.theta) * kDegrees);
  }
  return errors;
}

AteErrors absoluteErrors(const Trajectory& estimate, const Trajectory& truth, bool align) {
  AteErrors errors;
  std::vector<std::pair<Pose2, Pose2>> pairs;  // estimate, truth
  for (const StampedPose& row : estimate) {
    const auto true_pose = poseAt(truth, row.stamp);
    if (true_pose) {
      pairs.emplace_back(row.pose, *true_pose);
    } else {
      ++errors.left_out;
    }
  }
  errors.used = static_cast<int>(pairs.size());
  if (pairs.empty()) return errors;

  if (align) {
    Eigen::Vector2d mean_e = Eigen::Vector2d::Zero(), mean_t = Eigen::Vector2d::Zero();
    for (const auto& [e, t] : pairs) {
      mean_e += e.translation();
      mean_t += t.translation();
    }
    mean_e /= errors.used;
    mean_t /= errors.used;
    double sine = 0.0, cosine = 0.0;
    for (const auto& [e, t] : pairs) {
      const Eigen::Vector2d a = e.translation() - mean_e, b = t.translation() - mean_t;
      cosine += a.dot(b);
      sine += a.x() * b.y() - a.y() * b.x();
    }
    errors.T_truth_estimate.theta = std::atan2(sine, cosine);
    const Eigen::Vector2d shift = mean_t - errors.T_truth_estimate * mean_e;
    errors.T_truth_estimate.x = shift.x();
    errors.T_truth_estimate.y = shift.y();
  }
  double squares = 0.0;
  for (const auto& [e, t] : pairs) {
    const Pose2 difference = between(t, errors.T_truth_estimate * e);
    const double distance = std::hypot(difference.x, difference.y);
    squares += distance * distance;
    errors.mean += distance / errors.used;
    errors.rotation_mean += std::abs(difference.theta) * kDegrees / errors.used;
    errors.max = std::max(errors.max, distance);
  }
  errors.rmse = std::sqrt(squares / errors.used);
  return errors;
}

}  // namespace slam
