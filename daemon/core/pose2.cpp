// SPDX-License-Identifier: BSD-3-Clause
#include "core/pose2.hpp"

#include <Eigen/LU>

namespace slam {
namespace {

constexpr double kSmallAngle = 1e-4;  // [rad] below this the series are exact to double precision

struct SincPair {
  double sinc;  // sin(t)/t
  double cosc;  // (1 - cos(t))/t
};

SincPair sincPair(double t) {
  if (std::abs(t) < kSmallAngle) return {1.0 - t * t / 6.0, t / 2.0 - t * t * t / 24.0};
  return {std::sin(t) / t, (1.0 - std::cos(t)) / t};
}

Eigen::Matrix2d rotation(double theta) {
  const double c = std::cos(theta), s = std::sin(theta);
  return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

}  // namespace

BinaryJacobians composeJacobians(const Pose2& T_a_b, const Pose2& T_b_c) {
  BinaryJacobians J{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()};
  const Eigen::Vector2d rotated = rotation(T_a_b.theta) * T_b_c.translation();
  J.first(0, 2) = -rotated.y();
  J.first(1, 2) = rotated.x();
  J.second.topLeftCorner<2, 2>() = rotation(T_a_b.theta);
  return J;
}

Eigen::Matrix3d inverseJacobian(const Pose2& T) {
  Eigen::Matrix3d J = -Eigen::Matrix3d::Identity();
  J.topLeftCorner<2, 2>() = -rotation(-T.theta);
  const Pose2 inverse = T.inverse();
  J(0, 2) = inverse.y;
  J(1, 2) = -inverse.x;
  return J;
}

BinaryJacobians betweenJacobians(const Pose2& T_w_a, const Pose2& T_w_b) {
  const BinaryJacobians compose = composeJacobians(T_w_a.inverse(), T_w_b);
  return {compose.first * inverseJacobian(T_w_a), compose.second};
}

Pose2 exp(const Eigen::Vector3d& xi) {
  const auto [sinc, cosc] = sincPair(xi.z());
  return {sinc * xi.x() - cosc * xi.y(), cosc * xi.x() + sinc * xi.y(), wrapAngle(xi.z())};
}

Eigen::Vector3d log(const Pose2& pose) {
  const double theta = wrapAngle(pose.theta);
  const auto [sinc, cosc] = sincPair(theta);
  const double norm = sinc * sinc + cosc * cosc;
  return {(sinc * pose.x + cosc * pose.y) / norm, (-cosc * pose.x + sinc * pose.y) / norm, theta};
}

Eigen::Matrix3d expRightJacobian(const Eigen::Vector3d& xi) {
  const double t = xi.z();
  const auto [sinc, cosc] = sincPair(t);
  // (t - sin t)/t^2 and (1 - cos t)/t^2, by series near zero
  const double a = std::abs(t) < kSmallAngle ? t / 6.0 : (t - std::sin(t)) / (t * t);
  const double b = std::abs(t) < kSmallAngle ? 0.5 - t * t / 24.0 : (1.0 - std::cos(t)) / (t * t);
  Eigen::Matrix3d J;
  J << sinc, cosc, a * xi.x() - b * xi.y(),  //
      -cosc, sinc, b * xi.x() + a * xi.y(),  //
      0.0, 0.0, 1.0;
  return J;
}

Eigen::Matrix3d logRightJacobian(const Pose2& pose) { return expRightJacobian(log(pose)).inverse(); }

}  // namespace slam
