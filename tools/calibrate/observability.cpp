// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/observability.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr double kMaxStraightTurn = 0.05;  // [rad] RMS turn of a motion that still counts as straight
constexpr double kMaxSpotTravel = 0.1;     // [1] RMS travel of the base against that of the wheels
constexpr double kMaxArcSpread = 0.05;     // [1] smaller against larger singular value of the wheels' increments

}  // namespace

Observability::Observability(const Matrix& information, const RobotGeometry& size) {
  size_ << size.left_radius, size.right_radius, size.track, size.track, size.track, 1.0;
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(size_.asDiagonal() * information * size_.asDiagonal());
  eigenvalues_ = solver.eigenvalues();
  directions_ = solver.eigenvectors();
  while (weak_ < 6 && !(eigenvalues_[weak_] * kMaxSigma * kMaxSigma > 1.0)) ++weak_;
}

Observability::Vector Observability::solve(const Matrix& information, const Vector& gradient) const {
  if (weak_ == 6) return Vector::Zero();
  const Eigen::Matrix<double, 6, Eigen::Dynamic> basis = size_.asDiagonal() * directions_.rightCols(6 - weak_);
  const Eigen::MatrixXd reduced = basis.transpose() * information * basis;
  return basis * reduced.ldlt().solve(basis.transpose() * gradient);
}

Observability::Matrix Observability::covariance() const {
  const Vector variances = eigenvalues_.unaryExpr([](double value) { return 1.0 / std::max(1.0, value); });
  const Matrix basis = size_.asDiagonal() * directions_;
  return basis * variances.asDiagonal() * basis.transpose();
}

std::array<bool, 6> Observability::determined() const {
  const Vector sigma = covariance().diagonal().cwiseSqrt().cwiseQuotient(size_);
  std::array<bool, 6> determined{};
  for (int i = 0; i < 6; ++i) determined[static_cast<std::size_t>(i)] = sigma[i] < kMaxSigma;
  return determined;
}

DriveKind driveKind(std::span<const LidarMotion> motions, const RobotGeometry& g) {
  double turns = 0.0, travels = 0.0, wheel_travels = 0.0;  // sums of squares [rad^2, m^2, m^2]
  Eigen::Matrix2d increments = Eigen::Matrix2d::Zero();
  for (const LidarMotion& motion : motions) {
    Eigen::Vector2d angles = Eigen::Vector2d::Zero();
    for (const WheelStep& step : motion.wheels) angles += Eigen::Vector2d(step.left, step.right);
    const double left = g.left_radius * angles[0], right = g.right_radius * angles[1];
    turns += motion.T_begin_end.theta * motion.T_begin_end.theta;
    travels += 0.25 * (left + right) * (left + right);
    wheel_travels += 0.5 * (left * left + right * right);
    increments += angles * angles.transpose();
  }
  const double count = std::max<double>(1.0, static_cast<double>(motions.size()));
  if (turns < count * kMaxStraightTurn * kMaxStraightTurn) return DriveKind::kStraight;
  if (travels < kMaxSpotTravel * kMaxSpotTravel * wheel_travels) return DriveKind::kOnTheSpot;
  const Eigen::Vector2d spread = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(increments).eigenvalues();
  if (spread[0] < kMaxArcSpread * kMaxArcSpread * spread[1]) return DriveKind::kOneArc;
  return DriveKind::kVaried;
}

const char* describe(DriveKind kind) {
  switch (kind) {
    case DriveKind::kStraight:
      return "the robot only drove straight on: the track and the lidar's x and y show in turns only; turn both ways, "
             "too";
    case DriveKind::kOnTheSpot:
      return "the robot only turned on the spot: the size of wheels and track and the direction of the lidar do not "
             "show "
             "without way; drive some metres, too";
    case DriveKind::kOneArc:
      return "the robot drove the same arc all the time: radii, track and the lidar's place cannot be told apart; "
             "drive "
             "straight and turn both ways, too";
    case DriveKind::kVaried:
      break;
  }
  return "the motions are too few or too noisy; drive for longer, straight and turning both ways";
}

}  // namespace slam
