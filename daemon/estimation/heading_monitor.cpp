// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/heading_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/pose2.hpp"

namespace slam {
void HeadingMonitor::compare(const GyroMonitor& gyro, Timestamp stamp, bool standstill, double theta, double variance) {
  const std::optional<Last> last = std::exchange(last_, Last{stamp, theta, standstill, 0.0});
  if (!last || stamp <= last->stamp) return;
  const double seconds = toSeconds(stamp - last->stamp);
  if (bias_) bias_->variance += square(config_.bias_walk) * seconds;
  const auto turn = gyro.turned(last->stamp, stamp);
  if (!turn) return;
  last_->rate = *turn / seconds;
  if (standstill && last->standstill) learnBias(last_->rate, square(config_.gyro_noise) / seconds);
  if (!bias_ || contradicts_) return;

  const double turned = *turn - bias_->value * seconds;
  difference_ += wrapAngle(wrapAngle(theta - last->theta) - turned);
  predict(seconds, turned, last_->rate - last->rate);
  correct(std::max(variance, square(config_.match_sigma)));
  contradicts_ = square(state_[kDrift]) > square(config_.contradiction) * (P_(kDrift, kDrift) + bias_->variance);
  if (contradicts_) bias_->variance += square(state_[kDrift]);  // if it is the gyro
}

/// What the bias has moved since the last rest was no drift of the scans.
void HeadingMonitor::learnBias(double rate, double variance) {
  if (!bias_) {
    bias_ = {rate, variance};
    return begin();
  }
  const double gain = bias_->variance / (bias_->variance + variance);
  const double moved = gain * (rate - bias_->value);
  bias_->value += moved;
  bias_->variance *= 1.0 - gain;
  if (!contradicts_) {
    state_[kDrift] += moved;
    return;
  }
  moved_ += moved;
  if (-moved_ * state_[kDrift] > 0.5 * square(state_[kDrift])) begin();
}

void HeadingMonitor::begin() {
  contradicts_ = false;
  difference_ = moved_ = 0.0;
  state_.setZero();
  P_ = Eigen::Vector3d(square(config_.match_sigma), square(config_.any_drift), square(config_.gyro_scale)).asDiagonal();
}

void HeadingMonitor::predict(double seconds, double turn, double rate_change) {
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F(kDifference, kDrift) = seconds;
  F(kDifference, kScale) = turn;
  state_ = (F * state_).eval();
  P_ = (F * P_ * F.transpose()).eval();
  P_(kDifference, kDifference) += square(config_.gyro_noise) * seconds + square(config_.time_offset * rate_change);
  P_(kDrift, kDrift) += square(config_.bias_walk) * seconds;
}

/// A leap from one scan to the next, as of a gyro that is read too seldom for a sudden stop, is no drift.
void HeadingMonitor::correct(double variance) {
  const double innovation = difference_ - state_[kDifference];
  const double expected = P_(kDifference, kDifference) + variance;
  if (square(innovation) > square(config_.contradiction) * expected) P_(kDifference, kDifference) += square(innovation);
  const Eigen::Vector3d K = P_.col(kDifference) / (P_(kDifference, kDifference) + variance);
  state_ += K * innovation;
  P_ -= (K * P_.row(kDifference)).eval();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
}

Eigen::Matrix3d HeadingMonitor::matchError() const {
  return (contradicts_ ? square(config_.match_error) : 0.0) * Eigen::Matrix3d::Identity();
}

}  // namespace slam
