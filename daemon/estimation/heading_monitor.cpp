// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/heading_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/pose2.hpp"

namespace slam {
namespace {

constexpr double kAnyDrift = 0.05;  // [rad/s] standard deviation before anything is known of it

double square(double x) { return x * x; }

}  // namespace

void HeadingMonitor::compare(const GyroMonitor& gyro, Timestamp stamp, bool standstill, double theta, double variance) {
  const std::optional<Last> last = std::exchange(last_, Last{stamp, theta, standstill});
  const bool rested = last && last->standstill && standstill;
  if (!rested) rest_ = {};
  const auto turn = last ? gyro.turned(last->stamp, stamp) : std::nullopt;
  if (!turn) return;
  const double seconds = toSeconds(stamp - last->stamp);
  if (rested) learnBias(seconds, *turn);
  if (!bias_ || contradicts_) return;

  const double turned = *turn - bias_->value * seconds;
  difference_ += wrapAngle(wrapAngle(theta - last->theta) - turned);
  bias_->variance += square(config_.bias_walk) * seconds;
  predict(seconds, turned);
  correct(std::max(variance, square(config_.match_sigma)));
  contradicts_ = square(state_[kDrift]) > square(config_.contradiction) * (P_(kDrift, kDrift) + bias_->variance);
}

/// What the bias has moved since the last rest was no drift of the scans.
void HeadingMonitor::learnBias(double seconds, double turn) {
  rest_ = {rest_.seconds + seconds, rest_.turn + turn};
  const GyroBias bias{rest_.turn / rest_.seconds, square(config_.gyro_noise) / rest_.seconds};
  if (bias_ && bias.variance > bias_->variance) return;
  const double moved = bias_ ? bias.value - bias_->value : 0.0;
  const bool explained = -moved * state_[kDrift] > 0.5 * square(state_[kDrift]);
  if (contradicts_ && !explained) return;
  if (contradicts_ || !bias_) {
    begin();
  } else {
    state_[kDrift] += moved;
  }
  contradicts_ = false;
  bias_ = bias;
}

void HeadingMonitor::begin() {
  difference_ = 0.0;
  state_.setZero();
  P_ = Eigen::Vector3d(square(config_.match_sigma), square(kAnyDrift), square(config_.gyro_scale)).asDiagonal();
}

void HeadingMonitor::predict(double seconds, double turn) {
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F(kDifference, kDrift) = seconds;
  F(kDifference, kScale) = turn;
  state_ = (F * state_).eval();
  P_ = (F * P_ * F.transpose()).eval();
  P_(kDifference, kDifference) += square(config_.gyro_noise) * seconds;
  P_(kDrift, kDrift) += square(config_.bias_walk) * seconds;
}

void HeadingMonitor::correct(double variance) {
  const Eigen::Vector3d K = P_.col(kDifference) / (P_(kDifference, kDifference) + variance);
  state_ += K * (difference_ - state_[kDifference]);
  P_ -= (K * P_.row(kDifference)).eval();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
}

Eigen::Matrix3d HeadingMonitor::matchError() const {
  return (contradicts_ ? square(config_.match_error) : 0.0) * Eigen::Matrix3d::Identity();
}

}  // namespace slam
