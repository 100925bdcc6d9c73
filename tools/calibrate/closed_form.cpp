// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/closed_form.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace slam {
namespace {

constexpr double kMinRcond = 1e-12;  // below this a step is singular in practice

struct TurnRatios {
  double J21, J22;  // [rad/rad] turn of the base per turn of the left and of the right wheel
};

std::optional<TurnRatios> solveRotation(std::span<const LidarMotion> motions) {
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Eigen::Vector2d y = Eigen::Vector2d::Zero();
  for (const LidarMotion& motion : motions) {
    Eigen::Vector2d angles = Eigen::Vector2d::Zero();
    for (const WheelStep& step : motion.wheels) angles += Eigen::Vector2d(step.left, step.right);
    A += angles * angles.transpose() / motion.covariance(2, 2);
    y += angles * motion.T_begin_end.theta / motion.covariance(2, 2);
  }
  const Eigen::LDLT<Eigen::Matrix2d> ldlt(A);
  if (!(ldlt.rcond() > kMinRcond)) return std::nullopt;
  const Eigen::Vector2d J = ldlt.solve(y);
  return TurnRatios{J[0], J[1]};
}

/// Motion of a base with these turn ratios and a track of 1 m.
Pose2 unitMotion(const TurnRatios& J, std::span<const WheelStep> wheels) {
  Pose2 pose;
  for (const WheelStep& step : wheels) {
    const double left = J.J21 * step.left, right = J.J22 * step.right;
    pose = pose * exp({(right - left) / 2.0, 0.0, left + right});
  }
  return pose;
}

using Matrix5 = Eigen::Matrix<double, 5, 5>;

Matrix5 quadraticForm(std::span<const LidarMotion> motions, const TurnRatios& J) {
  Matrix5 M = Matrix5::Zero();
  for (const LidarMotion& motion : motions) {
    const Pose2 c = unitMotion(J, motion.wheels);
    const Pose2& s = motion.T_begin_end;
    const double cos_turn = std::cos(c.theta), sin_turn = std::sin(c.theta);
    Eigen::Matrix<double, 2, 5> Q;
    Q << -c.x, 1.0 - cos_turn, sin_turn, s.x, -s.y,  //
        -c.y, -sin_turn, 1.0 - cos_turn, s.y, s.x;
    M += Q.transpose() * Q / (0.5 * motion.covariance.topLeftCorner<2, 2>().trace());
  }
  return M;
}

}  // namespace

std::optional<RobotGeometry> solveClosedForm(std::span<const LidarMotion> motions) {
  const auto J = solveRotation(motions);
  if (!J) return std::nullopt;
  const Matrix5 M = quadraticForm(motions, *J);
  const Eigen::Matrix3d A = M.topLeftCorner<3, 3>();
  const Eigen::Matrix<double, 3, 2> C = M.topRightCorner<3, 2>();
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(A);
  if (!(ldlt.rcond() > kMinRcond)) return std::nullopt;
  const Eigen::Matrix<double, 3, 2> A_inv_C = ldlt.solve(C);
  const Eigen::Matrix2d schur = M.bottomRightCorner<2, 2>() - C.transpose() * A_inv_C;
  Eigen::Vector2d direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(schur).eigenvectors().col(0);
  Eigen::Vector3d place = -A_inv_C * direction;  // (b, l_x, l_y)
  if (place[0] < 0.0) {
    place = -place;
    direction = -direction;
  }
  const RobotGeometry geometry{.left_radius = -J->J21 * place[0],
                               .right_radius = J->J22 * place[0],
                               .track = place[0],
                               .T_base_lidar = {place[1], place[2], std::atan2(direction[1], direction[0])}};
  const bool sound = geometry.vector().allFinite() && geometry.left_radius > 0.0 && geometry.right_radius > 0.0;
  return sound ? std::optional(geometry) : std::nullopt;
}

}  // namespace slam
