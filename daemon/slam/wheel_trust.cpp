// SPDX-License-Identifier: BSD-3-Clause
#include "slam/wheel_trust.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr double kMostAlone = 10.0;  // [1] one stretch counts for no more: a slip, a wrong match
constexpr double kLeastNoise = 0.1;  // [1] of the model's variance: the scans' own error is in it, too

double square(double x) { return x * x; }

}  // namespace

void WheelTrust::add(const Pose2& T_odom_base, const Pose2& T_map_base, bool turn_known) {
  if (!begin_) {
    begin_ = Begin{T_odom_base, T_map_base};
    return;
  }
  const Pose2 told = between(begin_->T_odom_base, T_odom_base), wheels = scale_.corrected(told);
  const Pose2 scans = between(begin_->T_map_base, T_map_base);
  const double distance = std::max(std::hypot(wheels.x, wheels.y), std::hypot(scans.x, scans.y));
  const double turn = std::abs(scans.theta);  // the wheels' own would excuse itself
  if (distance < config_.stretch && std::max(turn, std::abs(wheels.theta)) < config_.stretch) return;
  begin_ = Begin{T_odom_base, T_map_base};
  const auto remember = [&](double error, double variance, double& mean) {
    mean += (std::min(kMostAlone, square(error) / variance) - mean) / config_.memory;
  };
  if (distance > config_.stretch) {
    const double variance = noise_.wheelTranslationVariance(distance) + square(config_.scan_distance);
    remember(std::hypot(wheels.x - scans.x, wheels.y - scans.y), variance, distance_error_);
    scale_.add(told, scans, variance, std::max(kLeastNoise, distance_error_));
  }
  if (turn_known) {
    remember(wrapAngle(wheels.theta - scans.theta),
             noise_.wheelRotationVariance(distance, turn) + square(config_.scan_turn), turn_error_);
  }
  if (believed_ && worst() > config_.contradiction) ++withdrawn_;
  believed_ = worst() < (believed_ ? config_.contradiction : config_.agreement);
}

}  // namespace slam
