// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/wheel_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slam {
namespace {

double square(double x) { return x * x; }

}  // namespace

void StillWheels::add(const WheelSample& sample, std::optional<double> turned, const WheelMonitorConfig& config) {
  const std::optional<WheelSample> last = std::exchange(last_, sample);
  const double seconds = last ? toSeconds(sample.stamp - last->stamp) : 0.0;
  if (!(seconds > 0.0) || sample.restarted) return;
  const Pose2 moved = between(last->T_wheels_base, sample.T_wheels_base);
  const double speed = std::hypot(moved.x, moved.y) / seconds;
  const bool was_still = std::exchange(still_, StandstillConfig().isQuiet(speed, moved.theta / seconds));
  if (!still_) {
    speed_ = std::min(speed, std::exchange(newest_speed_, speed));
    turned_ = path_ = moved_ = 0.0;
    dead_ = false;
    return rest_.reset();
  }
  newest_speed_ = 0.0;
  turned_ = was_still ? std::exp(-seconds / config.still_memory) * turned_ + turned.value_or(0.0) : 0.0;
  const bool stopped_too_soon = !was_still && speed_ > config.hardest_braking * seconds;
  if (!dead_ && (stopped_too_soon || std::abs(turned_) > config.still_turn)) {
    dead_ = true;
    rest_.reset();
  }
  if (!dead_) return;
  path_ += speed_ * seconds;
  longest_path_ = std::max(longest_path_, path_);
}

void StillWheels::compare(Timestamp stamp, const Pose2& T_map_base, bool complete, const WheelMonitorConfig& config) {
  if (!dead_ || !complete) return;
  if (!rest_) rest_ = Seen{stamp, T_map_base};
  const Pose2 moved = between(rest_->T_map_base, T_map_base);
  const double distance = std::hypot(moved.x, moved.y);
  if (distance > config.rest_motion || std::abs(moved.theta) > config.rest_motion) {
    moved_ += distance;
    rest_ = Seen{stamp, T_map_base};
  } else if (moved_ < config.dead_motion && toSeconds(stamp - rest_->stamp) >= config.rest_time) {
    dead_ = false;
    speed_ = turned_ = path_ = moved_ = 0.0;
  }
}

std::optional<WheelSample> WheelMonitor::listen(const WheelSample& sample, std::optional<double> turned) {
  const bool was_dead = still_.dead();
  still_.add(sample, turned, config_);
  if (still_.dead()) return std::nullopt;
  WheelSample heard = sample;
  heard.restarted |= was_dead;  // what they kept back is not made up for
  return heard;
}

std::optional<WheelSample> WheelMonitor::hear(const WheelSample& sample, bool unmatched) {
  heard_ = true;
  WheelSample corrected = sample;
  corrected.T_wheels_base = rescaled_.add(sample.T_wheels_base, scale_);
  const bool held_back = std::exchange(held_back_, !reliable_ && !unmatched);
  if (held_back_) return std::nullopt;
  corrected.restarted |= held_back;  // what they told meanwhile is not made up for
  return corrected;
}

WheelReliability WheelMonitor::reliability() const {
  if (!heard_) return WheelReliability::kNone;
  if (!reliable_ || still_.dead()) return WheelReliability::kRejected;
  return worst() <= config_.consistency ? WheelReliability::kConsistent : WheelReliability::kReliable;
}

void WheelMonitor::compare(const Ekf& odometry, const Pose2& T_map_base, bool complete) {
  if (!heard_) return;
  still_.compare(odometry.stamp(), T_map_base, complete, config_);
  if (!complete || odometry.wheelsSilent()) return interrupt();
  compare(odometry.pose(), T_map_base, !odometry.gyroActive());
}

void WheelMonitor::compare(const Pose2& T_odom_base, const Pose2& T_map_base, bool turn_known) {
  if (!begin_) {
    begin_ = Begin{T_odom_base, T_map_base};
    return;
  }
  const Pose2 told = between(begin_->T_odom_base, T_odom_base), wheels = scale_.corrected(told);
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
    scale_.add(told, scans, variance, std::max(config_.least_noise, distance_error_));
  }
  if (turn_known) {
    remember(wrapAngle(wheels.theta - scans.theta),
             noise_.wheelRotationVariance(distance, turn) + square(config_.scan_turn), turn_error_);
  }
  if (reliable_ && worst() > config_.contradiction) ++rejections_;
  reliable_ = worst() < (reliable_ ? config_.contradiction : config_.agreement);
}

}  // namespace slam
