// SPDX-License-Identifier: BSD-3-Clause
#include "matching/icp.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace slam {
namespace {

struct PairSums {
  int pairs = 0;
  Eigen::Vector2d x = Eigen::Vector2d::Zero(), p = Eigen::Vector2d::Zero();  // sums of both sides
  Eigen::Matrix2d px = Eigen::Matrix2d::Zero();                              // sum p x^T
  double squared_distance = 0.0;                                             // [m^2]
  double squared_lever = 0.0;                                                // [m^2] sum |p|^2
};

PairSums pairUp(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T, double gate) {
  PairSums sums;
  for (const ScanPoint& point : points) {
    const Eigen::Vector2d p_ref = T * point.position;
    const Surfel* surfel = reference.nearest(p_ref, gate);
    if (surfel == nullptr) continue;
    const Eigen::Vector2d x(surfel->x, surfel->y);
    const double squared = (x - p_ref).squaredNorm();
    if (squared > gate * gate) continue;
    ++sums.pairs;
    sums.x += x;
    sums.p += point.position;
    sums.px += point.position * x.transpose();
    sums.squared_distance += squared;
    sums.squared_lever += point.position.squaredNorm();
  }
  return sums;
}

/// Eq. (3)-(5): the rigid motion that takes the points p onto their partners x.
Pose2 align(const PairSums& sums) {
  const double k = sums.pairs;
  const Eigen::Vector2d u_x = sums.x / k, u_p = sums.p / k;
  const Eigen::Matrix2d W = sums.px - k * u_p * u_x.transpose();  // (3)
  const Eigen::JacobiSVD<Eigen::Matrix2d> svd(W, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix2d V = svd.matrixV();
  if ((V * svd.matrixU().transpose()).determinant() < 0.0) V.col(1) *= -1.0;
  // The paper prints R = U V^T; the minimum for its own W = U S V^T, with p on the left, is V U^T.
  const Eigen::Matrix2d R = V * svd.matrixU().transpose();  // (4)
  const Eigen::Vector2d t = u_x - R * u_p;                  // (5)
  return {t.x(), t.y(), std::atan2(R(1, 0), R(0, 0))};
}

}  // namespace

MatchResult matchPointToPoint(const Reference& reference, std::span<const ScanPoint> points, const Pose2& guess,
                              const MatchConfig& config) noexcept {
  MatchResult result{.T_ref_base = guess};
  const double reach =
      config.initial_pair_distance + config.search_translation + config.search_rotation * meanRange(points);
  double gate = std::max(reach, config.final_pair_distance);
  while (result.iterations < config.max_iterations) {
    ++result.iterations;
    const PairSums sums = pairUp(reference, points, result.T_ref_base, gate);
    result.pairs = sums.pairs;
    result.overlap = points.empty() ? 0.0 : static_cast<double>(sums.pairs) / static_cast<double>(points.size());
    result.status = MatchStatus::kTooFewPairs;
    if (sums.pairs < config.min_pairs) return result;

    const Pose2 next = align(sums);
    const Pose2 step = between(result.T_ref_base, next);
    result.T_ref_base = next;
    const bool narrow = gate <= config.final_pair_distance;
    gate = std::max(config.final_pair_distance, gate * config.pair_distance_decay);
    const bool settled =
        std::hypot(step.x, step.y) < config.translation_tolerance && std::abs(step.theta) < config.rotation_tolerance;
    if (!settled || !narrow) continue;

    result.residual = std::sqrt(sums.squared_distance / sums.pairs);
    const double variance = std::max(config.range_sigma * config.range_sigma, sums.squared_distance / sums.pairs);
    result.covariance.diagonal() << variance / sums.pairs, variance / sums.pairs,
        variance / std::max(1e-6, sums.squared_lever);
    result.observable = 3;
    result.status = result.overlap < config.min_overlap ? MatchStatus::kLowOverlap : MatchStatus::kConverged;
    return result;
  }
  result.status = MatchStatus::kIterationLimit;
  return result;
}

}  // namespace slam
