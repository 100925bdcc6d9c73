// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/calibration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>
#include <random>

#include "tools/calibrate/closed_form.hpp"
#include "tools/calibrate/misfit.hpp"

namespace slam {
namespace {

using Vector = RobotGeometry::Vector;
using Matrix = Observability::Matrix;

constexpr int kMaxSteps = 30;
constexpr int kMaxRounds = 30;
constexpr double kMaxFactor = 3.0;    // [1] between the configured and the true radii and track
constexpr int kHandfuls = 200;        // with a third of outliers, 17 of them are expected to be without any
constexpr int kHandful = 6;           // motions; three determine the geometry
constexpr double kConverged = 1e-10;  // [1] length of a step against the geometry's

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

/// Slip without turning looks like a track without end: where there is more slip than turns, only this tells them
/// apart.
bool plausible(const RobotGeometry& geometry, const RobotGeometry& configured) {
  const auto near = [](double value, double believed) {
    return value > believed / kMaxFactor && value < believed * kMaxFactor;
  };
  return near(geometry.left_radius, configured.left_radius) && near(geometry.right_radius, configured.right_radius) &&
         near(geometry.track, configured.track);
}

RobotGeometry estimate(std::span<const LidarMotion> motions, const RobotGeometry& configured) {
  const Observability observability(linearize(configured, motions).information, configured);
  RobotGeometry geometry = configured;
  if (observability.weakDirections() == 0) {
    const auto solution = solveClosedForm(motions);
    if (solution && plausible(*solution, configured)) geometry = *solution;
  }
  for (int i = 0; i < kMaxSteps; ++i) {
    const NormalEquations equations = linearize(geometry, motions);
    const Vector step = observability.solve(equations.information, equations.gradient);
    geometry = RobotGeometry::fromVector(geometry.vector() + step);
    if (step.norm() < kConverged * geometry.vector().norm()) break;
  }
  return geometry;
}

/// Estimates from random handfuls of motions: some of them are free of outliers.
std::vector<RobotGeometry> candidates(std::span<const LidarMotion> motions, const RobotGeometry& configured) {
  std::mt19937 random(1);
  std::vector<RobotGeometry> candidates;
  for (int i = 0; i < kHandfuls; ++i) {
    std::vector<LidarMotion> handful;
    std::sample(motions.begin(), motions.end(), std::back_inserter(handful), kHandful, random);
    const auto solution = solveClosedForm(handful);
    const bool usable = solution && plausible(*solution, configured);
    const RobotGeometry geometry = usable ? *solution : estimate(handful, configured);
    if (plausible(geometry, configured)) candidates.push_back(geometry);
  }
  return candidates;
}

/// The candidate that most motions agree with. What agreement is, the noise of the better half tells: that of the
/// least median of squares [Rousseeuw 1984]. The least median itself would not do: where most motions are straight it
/// says nothing about the turns.
std::optional<RobotGeometry> mostAgreed(std::span<const LidarMotion> motions, const RobotGeometry& configured,
                                        double gate) {
  const std::vector<RobotGeometry> geometries = candidates(motions, configured);
  if (geometries.empty()) return std::nullopt;
  const auto best = [&](auto&& cost) {
    std::vector<double> costs;
    std::transform(geometries.begin(), geometries.end(), std::back_inserter(costs), cost);
    return geometries[static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin())];
  };
  const RobotGeometry least = best([&](const RobotGeometry& g) { return medianMisfit(misfits(g, motions)); });
  const auto weighted = scaled({motions.begin(), motions.end()}, robustScale(misfits(least, motions)));
  return best([&](const RobotGeometry& g) {
    double cost = 0.0;
    for (const Misfit& misfit : misfits(g, weighted)) cost += std::min(misfit.all, gate);
    return cost;
  });
}

/// The motions within the gate of a geometry, for the noise that the better half of all motions shows.
struct Agreement {
  std::vector<LidarMotion> motions;  // their covariances scaled to that noise
  std::vector<std::size_t> indices;
};

Agreement agreeing(const RobotGeometry& geometry, std::span<const LidarMotion> motions, double gate) {
  const NoiseScale scale = robustScale(misfits(geometry, motions));
  const std::vector<LidarMotion> weighted = scaled({motions.begin(), motions.end()}, scale);
  const std::vector<Misfit> misfit = misfits(geometry, weighted);
  Agreement agreement;
  for (std::size_t i = 0; i < weighted.size(); ++i) {
    if (misfit[i].all > gate) continue;
    agreement.motions.push_back(weighted[i]);
    agreement.indices.push_back(i);
  }
  return agreement;
}

RobotGeometry firstGeometry(std::span<const LidarMotion> motions, const RobotGeometry& configured, double gate) {
  const Observability observability(linearize(configured, motions).information, configured);
  const auto robust = observability.weakDirections() == 0 ? mostAgreed(motions, configured, gate) : std::nullopt;
  return robust ? *robust : estimate(motions, configured);
}

void describeResiduals(Calibration& result, std::span<const LidarMotion> motions) {
  for (const LidarMotion& motion : motions) {
    const Eigen::Vector3d e = residual(result.geometry, motion);
    result.translation_residual += e.head<2>().squaredNorm();
    result.rotation_residual += e.z() * e.z();
  }
  const auto count = static_cast<double>(motions.size());
  result.translation_residual = std::sqrt(result.translation_residual / count);
  result.rotation_residual = std::sqrt(result.rotation_residual / count);
}

/// What the motions used determine, and whether that is less than all motions would.
void judge(Calibration& result, std::span<const LidarMotion> motions, std::span<const LidarMotion> used,
           const RobotGeometry& configured) {
  const NoiseScale scale = fittedScale(misfits(result.geometry, used));
  const auto observabilityOf = [&](std::span<const LidarMotion> some) {
    const auto weighted = scaled({some.begin(), some.end()}, scale);
    return Observability(linearize(result.geometry, weighted).information, configured);
  };
  const auto complete = [](const auto& known) { return std::all_of(known.begin(), known.end(), std::identity()); };
  const Observability observability = observabilityOf(used);
  result.covariance = observability.covariance();
  result.determined = observability.determined();
  result.status = CalibrationStatus::kDone;
  if (!complete(result.determined)) {
    // Slip looks like turning to the wheels alone, so the lidar has to have seen a varied drive, too.
    const bool contradicted =
        complete(observabilityOf(motions).determined()) && driveKind(motions, result.geometry) == DriveKind::kVaried;
    result.status = contradicted ? CalibrationStatus::kContradicted : CalibrationStatus::kPartly;
  }
  result.translation_noise = scale.translation;
  result.rotation_noise = scale.rotation;
  result.drive = driveKind(used, result.geometry);
  describeResiduals(result, used);
}

}  // namespace

Calibration calibrate(std::span<const LidarMotion> motions, const RobotGeometry& configured,
                      const CalibrationConfig& config) {
  Calibration result{.geometry = configured, .used = static_cast<int>(motions.size())};
  if (result.used < config.min_motions) return result;

  // The noise level decides what counts as determined and as an outlier, so both are repeated until they agree.
  result.geometry = firstGeometry(motions, configured, config.gate);
  Agreement agreement;
  for (int round = 0; round < kMaxRounds; ++round) {
    Agreement next = agreeing(result.geometry, motions, config.gate);
    const bool settled = next.indices == agreement.indices;
    agreement = std::move(next);
    if (settled || agreement.indices.empty()) break;
    result.geometry = estimate(agreement.motions, configured);
  }
  result.used = static_cast<int>(agreement.indices.size());
  result.rejected = static_cast<int>(motions.size()) - result.used;
  if (result.used < config.min_kept * static_cast<double>(motions.size()) || !plausible(result.geometry, configured)) {
    result.status = CalibrationStatus::kContradicted;
    return result;
  }

  std::vector<LidarMotion> used;
  for (const std::size_t i : agreement.indices) used.push_back(motions[i]);
  judge(result, motions, used, configured);
  return result;
}

}  // namespace slam
