// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <numbers>

namespace slam {

inline double square(double value) { return value * value; }

/// @return angle [rad] in [-pi, pi]
inline double wrapAngle(double angle) {
  if (std::abs(angle) <= std::numbers::pi) return angle;  // as nearly all are, and a remainder takes a call
  return std::remainder(angle, 2.0 * std::numbers::pi);
}

/// Rigid transform of the plane, T_a_b: takes coordinates of frame b to frame a, p_a = T_a_b * p_b.
struct Pose2 {
  double x = 0.0;      ///< [m]
  double y = 0.0;      ///< [m]
  double theta = 0.0;  ///< [rad], counter-clockwise

  Eigen::Vector2d translation() const { return {x, y}; }
  Eigen::Vector3d vector() const { return {x, y, theta}; }
  static Pose2 fromVector(const Eigen::Vector3d& v) { return {v.x(), v.y(), wrapAngle(v.z())}; }

  /// @return T_b_a
  Pose2 inverse() const {
    const double c = std::cos(theta), s = std::sin(theta);
    return {-c * x - s * y, s * x - c * y, wrapAngle(-theta)};
  }

  friend bool operator==(const Pose2&, const Pose2&) = default;
};

/// T_a_c = T_a_b * T_b_c
inline Pose2 operator*(const Pose2& T_a_b, const Pose2& T_b_c) {
  const double c = std::cos(T_a_b.theta), s = std::sin(T_a_b.theta);
  return {T_a_b.x + c * T_b_c.x - s * T_b_c.y, T_a_b.y + s * T_b_c.x + c * T_b_c.y,
          wrapAngle(T_a_b.theta + T_b_c.theta)};
}

/// A pose that takes many points or directions to its frame: sine and cosine are computed once.
class PointTransform {
 public:
  explicit PointTransform(const Pose2& T_a_b)
      : x_(T_a_b.x), y_(T_a_b.y), cos_(std::cos(T_a_b.theta)), sin_(std::sin(T_a_b.theta)) {}

  /// p_a = T_a_b * p_b
  Eigen::Vector2d operator*(const Eigen::Vector2d& p_b) const {
    return {x_ + cos_ * p_b.x() - sin_ * p_b.y(), y_ + sin_ * p_b.x() + cos_ * p_b.y()};
  }
  /// A direction, or a point about b's origin, in a's axes.
  Eigen::Vector2d turned(const Eigen::Vector2d& v_b) const {
    return {cos_ * v_b.x() - sin_ * v_b.y(), sin_ * v_b.x() + cos_ * v_b.y()};
  }

 private:
  double x_, y_, cos_, sin_;
};

/// p_a = T_a_b * p_b
inline Eigen::Vector2d operator*(const Pose2& T_a_b, const Eigen::Vector2d& p_b) { return PointTransform(T_a_b) * p_b; }

/// @return T_a_b from T_w_a and T_w_b
inline Pose2 between(const Pose2& T_w_a, const Pose2& T_w_b) { return T_w_a.inverse() * T_w_b; }

inline bool isFinite(const Pose2& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.theta);
}

/// Derivatives of a binary operation by the coordinates (x, y, theta) of its two arguments.
struct BinaryJacobians {
  Eigen::Matrix3d first;
  Eigen::Matrix3d second;
};

/// Jacobians of T_a_b * T_b_c.
BinaryJacobians composeJacobians(const Pose2& T_a_b, const Pose2& T_b_c);

/// Jacobian of T.inverse() by the coordinates of T.
Eigen::Matrix3d inverseJacobian(const Pose2& T);

/// Jacobians of between(T_w_a, T_w_b).
BinaryJacobians betweenJacobians(const Pose2& T_w_a, const Pose2& T_w_b);

/// Pose reached after unit time at the constant body twist xi = (rho_x [m], rho_y [m], theta [rad]).
/// [Sola 2018] J. Sola et al., "A micro Lie theory for state estimation in robotics", eq. (156)-(158).
Pose2 exp(const Eigen::Vector3d& xi);

/// Inverse of exp(): the twist with theta in [-pi, pi].
Eigen::Vector3d log(const Pose2& pose);

/// J_r with exp(xi + d) ~ exp(xi) * exp(J_r d) for small d [Sola 2018, eq. (163)].
Eigen::Matrix3d expRightJacobian(const Eigen::Vector3d& xi);

/// J_r^-1 with log(T * exp(d)) ~ log(T) + J_r^-1 d for small d [Sola 2018, section II-E]; |theta| < 2 pi.
Eigen::Matrix3d logRightJacobian(const Pose2& pose);

}  // namespace slam
