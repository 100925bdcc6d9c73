// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/wheel_monitor.hpp"

#include <cmath>
#include <utility>

namespace slam {
std::optional<WheelSample> WheelMonitor::add(const WheelSample& sample, bool unmatched) {
  has_samples_ = true;
  WheelSample corrected = sample;
  corrected.T_wheels_base = rescaled_.add(sample.T_wheels_base, scale_);
  const bool held_back = std::exchange(held_back_, !reliable_ && !unmatched);
  if (held_back_) return std::nullopt;
  corrected.restarted |= held_back;  // what they reported meanwhile is not made up for
  return corrected;
}

WheelReliability WheelMonitor::reliability() const {
  if (!has_samples_) return WheelReliability::kNone;
  if (!reliable_) return WheelReliability::kRejected;
  return worst() <= config_.consistency ? WheelReliability::kConsistent : WheelReliability::kReliable;
}

void WheelMonitor::compare(const Ekf& odometry, const Pose2& T_map_base, bool complete) {
  if (!has_samples_) return;
  if (!complete || odometry.wheelsSilent()) return interrupt();
  compare(odometry.pose(), T_map_base, !odometry.gyroActive());
}

void WheelMonitor::compare(const Pose2& T_odom_base, const Pose2& T_map_base, bool turn_known) {
  if (!begin_) {
    begin_ = Begin{T_odom_base, T_map_base};
    return;
  }
  const Pose2 measured = between(begin_->T_odom_base, T_odom_base), wheels = scale_.corrected(measured);
  const Pose2 scans = between(begin_->T_map_base, T_map_base);
  const double distance = std::max(std::hypot(wheels.x, wheels.y), std::hypot(scans.x, scans.y));
  const double turn = std::abs(scans.theta);  // the wheels' own would excuse itself
  if (distance < config_.interval && std::max(turn, std::abs(wheels.theta)) < config_.interval) return;
  begin_ = Begin{T_odom_base, T_map_base};
  const auto remember = [&](double error, double variance, double& mean) {
    mean += (std::min(config_.largest_error, square(error) / variance) - mean) / config_.memory;
  };
  if (distance > config_.interval) {
    const double variance = noise_.wheelTranslationVariance(distance) + square(config_.scan_distance);
    remember(std::hypot(wheels.x - scans.x, wheels.y - scans.y), variance, distance_error_);
    scale_.add(measured, scans, variance, std::max(config_.least_noise, distance_error_));
  }
  if (turn_known) {
    remember(wrapAngle(wheels.theta - scans.theta),
             noise_.wheelRotationVariance(distance, turn) + square(config_.scan_turn), turn_error_);
  }
  if (reliable_ && worst() > config_.contradiction) ++rejections_;
  reliable_ = worst() < (reliable_ ? config_.contradiction : config_.agreement);
}

}  // namespace slam
