// SPDX-License-Identifier: BSD-3-Clause
#include "estimation/scan_monitor.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/pose_covariance.hpp"

namespace slam {
double ScanMonitor::kept(const Pose2& moved) const {
  return std::exp(-std::hypot(moved.x, moved.y) / config_.memory - std::abs(moved.theta) / (2.0 * std::numbers::pi));
}

void ScanMonitor::compare(const Ekf& odometry, const Pose2& T_map_base, const Eigen::Matrix3d& covariance,
                          const WheelMonitor& wheels, const HeadingMonitor& gyro_scale) {
  if (wheels.reliability() == WheelReliability::kNone || odometry.wheelsSilent()) {
    contradicts_ = false;  // nobody does
    return interrupt();
  }
  const Last now{odometry.stamp(), odometry.pose(), T_map_base};
  const std::optional<Last> last = std::exchange(last_, now);
  if (!last) return;
  const Pose2 moved = wheels.scale().corrected(between(last->T_odom_base, now.T_odom_base));
  const double seconds = toSeconds(now.stamp - last->stamp);
  const double distance = std::hypot(moved.x, moved.y), turn = std::abs(moved.theta);
  const double keep = kept(moved);

  const Eigen::Matrix3d Ad = carrying(moved);
  difference_ = keep * Ad * difference_ + between(moved, between(last->T_map_base, now.T_map_base)).vector();
  by_bias_ = keep * Ad * by_bias_ + Eigen::Vector3d(0.0, 0.0, seconds);
  by_turn_ = keep * Ad * by_turn_ + Eigen::Vector3d(0.0, 0.0, moved.theta);
  by_scale_ = keep * Ad * by_scale_ + Eigen::Vector3d(moved.x, moved.y, 0.0);
  noise_sum_ = (square(keep) * Ad * noise_sum_ * Ad.transpose()).eval();
  const double drift =
      square(noise_.translation_drift) * seconds + (odometry.slip() ? square(noise_.slip_speed_sigma * seconds) : 0.0);
  const double across = wheels.shownVariance(distance) + drift;
  const double heading_noise = noise_.headingVariance(seconds, distance, turn, odometry.gyroActive());
  noise_sum_.diagonal() += Eigen::Vector3d(across, across, heading_noise);

  const GyroBias bias = odometry.gyroBiasEstimate();
  Eigen::Matrix3d S = noise_sum_ + rotated(covariance, -T_map_base.theta);
  S += square(wheels.scale().sigma()) * by_scale_ * by_scale_.transpose();
  Eigen::Vector3d difference = difference_;
  double turn_scale = noise_.wheel_turn_rate_scale;
  if (odometry.gyroActive()) {
    S += bias.variance * by_bias_ * by_bias_.transpose();
    difference -= gyro_scale.scale() * by_turn_;
    turn_scale = gyro_scale.scaleSigma();
  }
  S += square(turn_scale) * by_turn_ * by_turn_.transpose();
  const double place = difference.head<2>().dot(S.topLeftCorner<2, 2>().inverse() * difference.head<2>());
  const double heading = square(difference.z()) / S(2, 2);
  // What is left of D when the noise is taken off. A heading that is off by itself is the gyro's as often.
  const auto excess = [&](double chi_square) {
    return std::sqrt(std::max(0.0, 1.0 - square(config_.contradiction) / std::max(chi_square, 1e-9)));
  };
  const double of_place = excess(place), of_heading = std::max(of_place, excess(heading));
  const Eigen::Vector3d beyond = difference.cwiseProduct(Eigen::Vector3d(of_place, of_place, of_heading));
  contradicts_ = of_place > 0.0;
  excess_ = beyond * beyond.transpose();
}

}  // namespace slam
