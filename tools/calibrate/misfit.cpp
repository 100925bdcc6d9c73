// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/misfit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr double kMedianOf1 = 0.4549;                // of a chi-square of 1 degree of freedom ...
constexpr double kMedianOf2 = 1.3863;                // ... and of 2
constexpr int kTurnUnknowns = 2, kPathUnknowns = 4;  // J21, J22 show in the turns, the rest in the translations

double median(std::span<const Misfit> misfits, double Misfit::*part) {
  std::vector<double> values;
  for (const Misfit& misfit : misfits) values.push_back(misfit.*part);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double sum(std::span<const Misfit> misfits, double Misfit::*part) {
  double sum = 0.0;
  for (const Misfit& misfit : misfits) sum += misfit.*part;
  return sum;
}

NoiseScale fromVariances(double translation, double rotation) {
  return {std::sqrt(std::max(1.0, translation)), std::sqrt(std::max(1.0, rotation))};
}

}  // namespace

Eigen::Vector3d residual(const RobotGeometry& geometry, const LidarMotion& motion) {
  const Pose2 predicted = predictPose(geometry, motion.wheels);
  return {motion.T_begin_end.x - predicted.x, motion.T_begin_end.y - predicted.y,
          wrapAngle(motion.T_begin_end.theta - predicted.theta)};
}

std::vector<Misfit> misfits(const RobotGeometry& geometry, std::span<const LidarMotion> motions) {
  std::vector<Misfit> misfits;
  misfits.reserve(motions.size());
  for (const LidarMotion& motion : motions) {
    const Eigen::Vector3d e = residual(geometry, motion);
    const Eigen::Vector2d e_xy = e.head<2>();
    const Eigen::Matrix2d P_xy = motion.covariance.topLeftCorner<2, 2>();
    misfits.push_back({e_xy.dot(P_xy.ldlt().solve(e_xy)), e.z() * e.z() / motion.covariance(2, 2),
                       e.dot(motion.covariance.ldlt().solve(e))});
  }
  return misfits;
}

double medianMisfit(std::span<const Misfit> misfits) { return median(misfits, &Misfit::all); }

NoiseScale robustScale(std::span<const Misfit> misfits) {
  return fromVariances(median(misfits, &Misfit::translation) / kMedianOf2,
                       median(misfits, &Misfit::rotation) / kMedianOf1);
}

NoiseScale fittedScale(std::span<const Misfit> misfits) {
  const auto n = static_cast<double>(misfits.size());
  return fromVariances(sum(misfits, &Misfit::translation) / (2.0 * n - kPathUnknowns),
                       sum(misfits, &Misfit::rotation) / (n - kTurnUnknowns));
}

std::vector<LidarMotion> scaled(std::vector<LidarMotion> motions, const NoiseScale& scale) {
  const Eigen::Vector3d factors{scale.translation, scale.translation, scale.rotation};
  for (LidarMotion& motion : motions) {
    motion.covariance = factors.asDiagonal() * motion.covariance * factors.asDiagonal();
  }
  return motions;
}

}  // namespace slam
