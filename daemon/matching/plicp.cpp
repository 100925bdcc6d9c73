// SPDX-License-Identifier: BSD-3-Clause
#include "matching/plicp.hpp"

#include <algorithm>
#include <cmath>

#include "matching/linearisation.hpp"
#include "matching/normal_equations.hpp"

namespace slam {
namespace {

/// How far the parts of a scan would take the pose if each were followed alone, at the pose where their pulls cancel: a
/// cluster-robust ("sandwich") covariance. Noise of single points cancels within a part; furniture that was moved, or a
/// map that is bent, does not. [Liang 1986] K.-Y. Liang and S. Zeger, "Longitudinal data analysis using generalized
/// linear models", Biometrika 73(1).
/// @param inverse of the equations, in the directions that they determine
Eigen::Matrix3d tensionAt(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T,
                          const Eigen::Matrix3d& inverse, const MatchConfig& config) {
  return inverse * pullsOfParts(reference, points, T, config) * inverse;
}

/// Share of the promised information along `direction` that the gradient shows when the scan is displaced by a surfel
/// either way and the pairs are searched anew, 0..1. Points in a row find a partner wherever they are moved to: what
/// they seem to know of the direction along the row is not there.
double confirmedShare(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T, double gate,
                      const Eigen::Vector3d& direction, const MatchConfig& config) {
  const double distance = std::min(reference.config().surfel_spacing, config.overlap_distance);
  const auto displaced = [&](double metres) {
    const Pose2 moved = Pose2::fromVector(T.vector() + metres * direction);
    return linearise(reference, points, moved, gate, config.kernel_scale, config).equations;
  };
  const NormalEquations ahead = displaced(distance), behind = displaced(-distance);
  const double found = direction.dot(ahead.g - behind.g);
  const double promised = distance * direction.dot((ahead.H + behind.H) * direction);
  return promised > 0.0 ? std::clamp(found / promised, 0.0, 1.0) : 0.0;
}

/// What a match that has settled is worth. @param confirmed share of the information along the weakest direction
void conclude(MatchResult& result, const Linearisation& sums, const ObservableStep& solution, double confirmed,
              const Pose2& guess, const MatchConfig& config) {
  result.residual = std::sqrt(sums.agreeing_error / std::max(1, sums.agreeing));
  const double variance =
      std::max(config.range_sigma * config.range_sigma, sums.equations.squared_error / sums.equations.weight);
  const Eigen::Vector3d& weakest = solution.weakest;
  // An error is the gradient's noise by its slope, and of the slope only the confirmed share is there.
  const double excess = (1.0 / (confirmed * confirmed) - 1.0) / weakest.dot(sums.equations.H * weakest);
  result.covariance = variance * (solution.inverse + excess * weakest * weakest.transpose()) + result.tension;
  result.directions = solution.directions;
  // Earlier iterations may have taken a direction that is degenerate for a visible one: take their steps back.
  const auto degenerate = result.directions.rightCols(3 - result.observable);
  Pose2& T = result.T_ref_base;
  const Eigen::Vector3d moved(T.x - guess.x, T.y - guess.y, wrapAngle(T.theta - guess.theta));
  T = Pose2::fromVector(T.vector() - degenerate * (degenerate.transpose() * moved));
  if (result.overlap < config.min_overlap) {
    result.status = MatchStatus::kLowOverlap;
  } else {
    result.status = solution.observable == 3 ? MatchStatus::kConverged : MatchStatus::kUnobservable;
  }
}

}  // namespace

MatchResult matchPointToLine(const Reference& reference, std::span<const ScanPoint> points, const Pose2& guess,
                             const MatchConfig& config) noexcept {
  MatchResult result{.T_ref_base = guess};
  Pose2& T = result.T_ref_base;
  const double lever = meanRange(points);
  const double reach = config.initial_pair_distance + config.search_translation + config.search_rotation * lever;
  double gate = std::max(reach, config.final_pair_distance);
  int most = 3;          // directions believed observable
  double damping = 1.0;  // pairs that swap to and fro make the step oscillate: shorten it
  Eigen::Vector3d last_step = Eigen::Vector3d::Zero();
  while (result.iterations < config.max_iterations) {
    ++result.iterations;
    // A far guess makes large residuals of good pairs: the kernel narrows with the gate.
    const double widening = std::max(1.0, gate / config.final_pair_distance);
    const double kernel_scale = config.kernel_scale * widening * widening;
    const Linearisation sums = linearise(reference, points, T, gate, kernel_scale, config);
    const NormalEquations& equations = sums.equations;
    result.pairs = equations.pairs;
    // Of the points that the reference can have: a wall beyond its window contradicts nothing.
    const double covered = std::max(1, sums.covered);
    result.overlap = static_cast<double>(sums.agreeing) / covered;
    result.known_ratio = static_cast<double>(sums.known) / covered;
    result.status = MatchStatus::kTooFewPairs;
    if (equations.pairs < config.min_pairs) return result;

    const ObservableStep solution = solveObservable(equations, lever, config.min_information, most);
    result.observable = solution.observable;
    result.status = MatchStatus::kUnobservable;
    if (solution.observable == 0) return result;

    if (solution.step.dot(last_step) < 0.0) damping *= config.damping;
    last_step = solution.step;
    const Eigen::Vector3d step = damping * solution.step;
    T = {T.x + step.x(), T.y + step.y(), wrapAngle(T.theta + step.z())};
    const bool narrow = gate <= config.final_pair_distance;
    gate = std::max(config.final_pair_distance, gate * config.pair_distance_decay);
    const bool settled =
        step.head<2>().norm() < config.translation_tolerance && std::abs(step.z()) < config.rotation_tolerance;
    if (!settled) continue;
    if (!narrow) {  // nothing moves at the wide gate: go to the narrow one at once
      gate = config.final_pair_distance;
      continue;
    }

    const double confirmed = confirmedShare(reference, points, T, gate, solution.weakest, config);
    if (confirmed < config.min_confirmed) {  // degenerate: settle once more without it
      most = solution.observable - 1;
      continue;
    }

    result.tension = tensionAt(reference, points, T, solution.inverse, config);
    conclude(result, sums, solution, confirmed, guess, config);
    return result;
  }
  result.status = MatchStatus::kIterationLimit;
  return result;
}

double overlapAt(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T_ref_base,
                 double distance, const MatchConfig& config) noexcept {
  MatchConfig near = config;
  near.overlap_distance = distance;
  const Linearisation sums =
      linearise(reference, points, T_ref_base, config.final_pair_distance, config.kernel_scale, near);
  return static_cast<double>(sums.agreeing) / std::max(1, sums.covered);
}

}  // namespace slam
