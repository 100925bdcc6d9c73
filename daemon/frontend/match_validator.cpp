// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/match_validator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "matching/plicp.hpp"

namespace slam {

MatchValidator::MatchValidator(const ValidatorConfig& config, const DynamicObjectGateConfig& gate,
                               const SearchWindow& reach, const Eigen::Vector2d& p_lidar)
    : lidar_(p_lidar), config_(config), reach_(reach), dynamic_objects_(gate) {}

void MatchValidator::removeDynamicBias(MatchResult& match, const Cloud& cloud, const LocalMap& local_map,
                                       const Prediction& predicted, const WheelMonitor& wheels) {
  if (!match.usable() || wheels.reliability() < WheelReliability::kConsistent) return;
  const Pose2 guess = predicted.pose.pose();
  if (wheels.slipped(wrapAngle(match.T_ref_base.theta - guess.theta))) return;
  const Eigen::Vector2d offset = match.T_ref_base.translation() - guess.translation();
  const Eigen::Matrix2d covariance = predicted.pose.covariance().topLeftCorner<2, 2>();
  const double sigma = std::sqrt(offset.dot(covariance * offset)) / std::max(offset.norm(), 1e-9);
  const bool rejected = dynamic_objects_.contradicts(offset, sigma)
                            ? dynamic_objects_.rejects(cloud.stamp, offset, support(match, guess, cloud, local_map))
                            : dynamic_objects_.stillRejects(cloud.stamp);
  if (!rejected) return;
  ++held_;
  match = projectedOut(match, guess.translation(), dynamic_objects_.direction());
}

/// Share of the scan that fits better where a match is than where the guess is, less of the walls it sees through.
double MatchValidator::support(const MatchResult& match, const Pose2& guess, const Cloud& cloud,
                               const LocalMap& local_map) {
  image_.set(cloud.points, lidar_);
  const auto fit = [&](const Pose2& T_map_base) {
    return overlapAt(local_map.reference(), cloud.points, T_map_base, cloud.match.kernel_scale, cloud.match) -
           local_map.reference().freeSpaceViolation(T_map_base, image_, cloud.match.known_observations);
  };
  return fit(match.T_ref_base) - fit({guess.x, guess.y, match.T_ref_base.theta});
}

bool MatchValidator::acceptTracking(const MatchResult& match, const Cloud& cloud, const LocalMap& local_map,
                                    const Ekf& predicted, const TrackingState& tracking) {
  // Behind a gap in the scans the robot may have been carried: one that has not moved sees what it saw.
  const double moved = (predicted.pose().translation() - tracking.lastPose().translation()).norm();
  const bool gap = tracking.unmatched(cloud.stamp) && moved < reach_.translation;
  if (tracking.failures() == 0 && !gap) return true;
  const bool as_before = match.usable() && match.overlap >= tracking.fusedOverlap() - config_.same_overlap;
  if (as_before && !contradictsGyro(match, predicted)) return true;
  return acceptSearch(match, cloud, local_map, predicted, tracking);
}

bool MatchValidator::acceptSearch(const MatchResult& match, const Cloud& cloud, const LocalMap& local_map,
                                  const Ekf& predicted, const TrackingState& tracking) {
  if (contradictsGyro(match, predicted)) return false;
  if (!match.usable() || match.overlap < config_.trusted_overlap) return false;
  const bool much_worse = match.overlap < tracking.fusedOverlap() - config_.much_worse;
  if (much_worse && !isNear(match.T_ref_base, tracking.lastPose())) return false;
  return !seesThroughWalls(match.T_ref_base, cloud, local_map, cloud.match.known_observations);
}

bool MatchValidator::seesThroughWalls(const Pose2& T_map_base, const Cloud& cloud, const LocalMap& local_map,
                                      double known) {
  image_.set(cloud.points, lidar_);
  return local_map.reference().freeSpaceViolation(T_map_base, image_, known) > config_.free_space_violation;
}

bool MatchValidator::wallsInTheOpen(const Cloud& cloud) {
  const bool many =
      cloud.walls.visible() >= cloud.match.min_pairs && cloud.walls.freeSpaceViolation() > config_.walls_in_the_open;
  if (!many) in_the_open_since_.reset();
  if (many && !in_the_open_since_) in_the_open_since_ = cloud.stamp;
  return many && toSeconds(cloud.stamp - *in_the_open_since_) >= config_.in_the_open_for;
}

/// A gyro turns with a robot that slips or is carried, so that its turn holds whatever the scans look like.
bool MatchValidator::contradictsGyro(const MatchResult& match, const Ekf& predicted) const {
  return std::abs(wrapAngle(match.T_ref_base.theta - predicted.pose().theta)) > headingTolerance(predicted);
}

double MatchValidator::headingTolerance(const Ekf& predicted) const {
  if (!predicted.gyroActive()) return std::numbers::pi;
  return config_.gyro_error + 3.0 * std::sqrt(predicted.covariance()(2, 2));
}

/// Whether a robot gets so far from scan to scan.
bool MatchValidator::isNear(const Pose2& T_map_base, const Pose2& last_pose) const {
  const Pose2 moved = between(last_pose, T_map_base);
  return std::max(std::abs(moved.x), std::abs(moved.y)) <= reach_.translation &&
         std::abs(moved.theta) <= reach_.rotation;
}

}  // namespace slam
