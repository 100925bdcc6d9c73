// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/wheel_model.hpp"

namespace slam {
namespace {

/// Twist of one step: rho_x [m], rho_y [m], theta [rad].
Eigen::Vector3d twist(const RobotGeometry& g, const WheelStep& step) {
  const double left = g.left_radius * step.left, right = g.right_radius * step.right;
  return {(left + right) / 2.0, 0.0, (right - left) / g.track};
}

struct BaseMotion {
  Pose2 T_begin_end;
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();  // by (r_L, r_R, b)
};

BaseMotion deadReckon(const RobotGeometry& g, std::span<const WheelStep> wheels) {
  BaseMotion motion;
  for (const WheelStep& step : wheels) {
    const Eigen::Vector3d xi = twist(g, step);
    Eigen::Matrix3d J_xi;
    J_xi << step.left / 2.0, step.right / 2.0, 0.0,  //
        0.0, 0.0, 0.0,                               //
        -step.left / g.track, step.right / g.track, -xi.z() / g.track;

    const Pose2 arc = exp(xi);
    const BinaryJacobians compose = composeJacobians(motion.T_begin_end, arc);
    const Eigen::Matrix3d J_arc = composeJacobians(arc, Pose2{}).second * expRightJacobian(xi) * J_xi;
    motion.jacobian = compose.first * motion.jacobian + compose.second * J_arc;
    motion.T_begin_end = motion.T_begin_end * arc;
  }
  return motion;
}

}  // namespace

Pose2 predictPose(const RobotGeometry& geometry, std::span<const WheelStep> wheels) {
  Pose2 T_begin_end;
  for (const WheelStep& step : wheels) T_begin_end = T_begin_end * exp(twist(geometry, step));
  return between(geometry.T_base_lidar, T_begin_end * geometry.T_base_lidar);
}

PredictedMotion predictMotion(const RobotGeometry& geometry, std::span<const WheelStep> wheels) {
  const BaseMotion base = deadReckon(geometry, wheels);
  const Pose2& lidar = geometry.T_base_lidar;
  const Pose2 T_begin_lidar = base.T_begin_end * lidar;
  const BinaryJacobians compose = composeJacobians(base.T_begin_end, lidar);
  const BinaryJacobians relative = betweenJacobians(lidar, T_begin_lidar);
  PredictedMotion predicted{between(lidar, T_begin_lidar), {}};
  predicted.jacobian.leftCols<3>() = relative.second * compose.first * base.jacobian;
  predicted.jacobian.rightCols<3>() = relative.first + relative.second * compose.second;
  return predicted;
}

}  // namespace slam
