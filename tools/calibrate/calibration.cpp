// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/calibration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tools/calibrate/closed_form.hpp"

namespace slam {
namespace {

using Vector = RobotGeometry::Vector;
using Matrix = Observability::Matrix;

constexpr int kMaxSteps = 30;
constexpr double kConverged = 1e-10;                 // [1] length of a step against the geometry's
constexpr double kMedianOf1 = 0.4549;                // of a chi-square of 1 degree of freedom ...
constexpr double kMedianOf2 = 1.3863;                // ... and of 2
constexpr int kTurnUnknowns = 2, kPathUnknowns = 4;  // J21, J22 show in the turns, the rest in the translations

Eigen::Vector3d residual(const RobotGeometry& geometry, const LidarMotion& motion) {
  const Pose2 predicted = predictMotion(geometry, motion.wheels).T_begin_end;
  return {motion.T_begin_end.x - predicted.x, motion.T_begin_end.y - predicted.y,
          wrapAngle(motion.T_begin_end.theta - predicted.theta)};
}

struct NormalEquations {
  Matrix information = Matrix::Zero();
  Vector gradient = Vector::Zero();
};

NormalEquations linearize(const RobotGeometry& geometry, std::span<const LidarMotion> motions) {
  NormalEquations sum;
  for (const LidarMotion& motion : motions) {
    const auto J = predictMotion(geometry, motion.wheels).jacobian;
    const Eigen::Matrix<double, 6, 3> JtW = motion.covariance.ldlt().solve(J).transpose();
    sum.information += JtW * J;
    sum.gradient += JtW * residual(geometry, motion);
  }
  return sum;
}

RobotGeometry estimate(std::span<const LidarMotion> motions, const RobotGeometry& configured) {
  const Observability observability(linearize(configured, motions).information, configured);
  RobotGeometry geometry = configured;
  if (observability.weakDirections() == 0) geometry = solveClosedForm(motions).value_or(configured);
  for (int i = 0; i < kMaxSteps; ++i) {
    const NormalEquations equations = linearize(geometry, motions);
    const Vector step = observability.solve(equations.information, equations.gradient);
    geometry = RobotGeometry::fromVector(geometry.vector() + step);
    if (step.norm() < kConverged * geometry.vector().norm()) break;
  }
  return geometry;
}

/// Squared residual of a motion against its covariance.
struct Misfit {
  double translation, rotation;  // [1] chi-square of 2 and of 1 degree of freedom
  double all;                    // [1] of 3
};

std::vector<Misfit> misfits(const RobotGeometry& geometry, std::span<const LidarMotion> motions) {
  std::vector<Misfit> misfits;
  for (const LidarMotion& motion : motions) {
    const Eigen::Vector3d e = residual(geometry, motion);
    const Eigen::Vector2d e_xy = e.head<2>();
    const Eigen::Matrix2d P_xy = motion.covariance.topLeftCorner<2, 2>();
    misfits.push_back({e_xy.dot(P_xy.ldlt().solve(e_xy)), e.z() * e.z() / motion.covariance(2, 2),
                       e.dot(motion.covariance.ldlt().solve(e))});
  }
  return misfits;
}

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

/// How much larger the residuals are than the motions' covariances say.
struct NoiseScale {
  double translation = 1.0, rotation = 1.0;  // [1] of sigmas, at least 1

  static NoiseScale fromVariances(double translation, double rotation) {
    return {std::sqrt(std::max(1.0, translation)), std::sqrt(std::max(1.0, rotation))};
  }
};

NoiseScale robustScale(std::span<const Misfit> misfits) {
  return NoiseScale::fromVariances(median(misfits, &Misfit::translation) / kMedianOf2,
                                   median(misfits, &Misfit::rotation) / kMedianOf1);
}

NoiseScale finalScale(std::span<const Misfit> misfits) {
  const auto n = static_cast<double>(misfits.size());
  return NoiseScale::fromVariances(sum(misfits, &Misfit::translation) / (2.0 * n - kPathUnknowns),
                                   sum(misfits, &Misfit::rotation) / (n - kTurnUnknowns));
}

std::vector<LidarMotion> scaled(std::vector<LidarMotion> motions, const NoiseScale& scale) {
  const Eigen::Vector3d factors{scale.translation, scale.translation, scale.rotation};
  for (LidarMotion& motion : motions) {
    motion.covariance = factors.asDiagonal() * motion.covariance * factors.asDiagonal();
  }
  return motions;
}

/// Removes the motions that fit worst, if beyond the gate, and at most `count` of them.
/// @return number removed
int discardWorst(std::vector<LidarMotion>& motions, std::span<const Misfit> misfits, double gate, int count) {
  std::vector<std::size_t> order(motions.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return misfits[a].all > misfits[b].all; });
  const auto end = std::find_if(order.begin(), order.begin() + count, [&](auto i) { return misfits[i].all <= gate; });
  std::sort(order.begin(), end, std::greater<>());
  for (auto i = order.begin(); i != end; ++i) motions.erase(motions.begin() + static_cast<std::ptrdiff_t>(*i));
  return static_cast<int>(end - order.begin());
}

void describeFit(Calibration& result, std::span<const LidarMotion> motions, const NoiseScale& scale) {
  for (const LidarMotion& motion : motions) {
    const Eigen::Vector3d e = residual(result.geometry, motion);
    result.translation_residual += e.head<2>().squaredNorm();
    result.rotation_residual += e.z() * e.z();
  }
  const auto count = static_cast<double>(motions.size());
  result.translation_residual = std::sqrt(result.translation_residual / count);
  result.rotation_residual = std::sqrt(result.rotation_residual / count);
  result.translation_noise = scale.translation;
  result.rotation_noise = scale.rotation;
  result.drive = driveKind(motions, result.geometry);
}

}  // namespace

Calibration calibrate(std::vector<LidarMotion> motions, const RobotGeometry& configured,
                      const CalibrationConfig& config) {
  Calibration result{.geometry = configured, .used = static_cast<int>(motions.size())};
  if (result.used < config.min_motions) return result;
  const double least = config.min_kept * result.used;
  const int at_once = std::max(1, static_cast<int>(config.discard_share * result.used));

  // The noise level changes what counts as determined and as an outlier, so the last round must begin with the level
  // that the one before it found.
  NoiseScale scale;
  for (bool settled = false;;) {
    const auto weighted = scaled(motions, scale);
    result.geometry = estimate(weighted, configured);
    const auto misfit = misfits(result.geometry, motions);
    scale = robustScale(misfit);
    const auto level = scaled(motions, scale);
    const int discarded = discardWorst(motions, misfits(result.geometry, level), config.gate, at_once);
    result.rejected += discarded;
    result.used -= discarded;
    if (result.used < least) {
      result.status = CalibrationStatus::kContradicted;
      return result;
    }
    if (discarded == 0 && settled) break;
    settled = discarded == 0;
  }

  scale = finalScale(misfits(result.geometry, motions));
  const auto weighted = scaled(motions, scale);
  const Observability observability(linearize(result.geometry, weighted).information, result.geometry);
  result.covariance = observability.covariance();
  result.determined = observability.determined();
  const bool all = std::all_of(result.determined.begin(), result.determined.end(), [](bool known) { return known; });
  result.status = all ? CalibrationStatus::kDone : CalibrationStatus::kPartly;
  describeFit(result, motions, scale);
  return result;
}

}  // namespace slam
