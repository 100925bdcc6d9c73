// SPDX-License-Identifier: BSD-3-Clause
#include "matching/plicp.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "matching/normal_equations.hpp"

namespace slam {
namespace {

constexpr std::size_t kPairsAtOnce = 32;  // looked up before the first is used: the reference is larger than the caches

struct Pair {
  const ScanPoint* point;
  const Surfel* surfel;
  float rx, ry;  // [m] R p
};

struct Sums {
  NormalEquations equations;
  int covered = 0;              // points in the reference's window
  int known = 0;                // pairs that agree with a well-known surfel
  int agreeing = 0;             // pairs within overlap_distance of their line or point
  double agreeing_error = 0.0;  // [m^2] sum of their squared residuals
  double observations = 0.0;    // of the surfels that they agree with
};

/// sum w r r^T of rows r: a processor works on a row's four numbers at once. In single precision, so of few rows.
using RowSum = Eigen::Matrix4f;
inline void addRow(RowSum& sum, float w, const Eigen::Vector4f& row) { sum.noalias() += (w * row) * row.transpose(); }

Sums linearize(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T, double gate,
               double kernel_scale, const MatchConfig& config) {
  const auto single = [](double value) { return static_cast<float>(value); };
  const double c = std::cos(T.theta), s = std::sin(T.theta);
  const float gate_squared = single(gate * gate), inverse_kernel = single(1.0 / (kernel_scale * kernel_scale));
  const float near = single(config.overlap_distance * config.overlap_distance),
              often = single(config.known_observations);
  const float point_weight = single(config.point_weight), same_face = single(config.same_face);
  const float grazing_observations = single(config.grazing_observations);
  const float x = single(T.x), y = single(T.y), cosine = single(c), sine = single(s);
  Sums sums;
  Eigen::Matrix4d rows = Eigen::Matrix4d::Zero(), spurious = Eigen::Matrix4d::Zero();
  std::array<Pair, kPairsAtOnce> pairs;
  for (std::size_t first = 0; first < points.size(); first += kPairsAtOnce) {
    std::size_t count = 0;
    for (const ScanPoint& point : points.subspan(first, std::min(kPairsAtOnce, points.size() - first))) {
      const double rx = c * point.position.x() - s * point.position.y();
      const double ry = s * point.position.x() + c * point.position.y();
      const Eigen::Vector2d p(T.x + rx, T.y + ry);
      if (!reference.covers(p)) continue;
      ++sums.covered;
      const Surfel* surfel = reference.nearest(p, gate);
      if (surfel == nullptr) continue;
      __builtin_prefetch(surfel);
      pairs[count++] = {&point, surfel, single(rx), single(ry)};
    }
    RowSum across = RowSum::Zero(), along = RowSum::Zero();  // of [n, n . R' p, e] and [t, t . R' p, 0]
    float weight = 0.0F, observations = 0.0F, agreeing_error = 0.0F;
    int agreeing = 0, known = 0;
    for (const Pair& pair : std::span(pairs).first(count)) {
      const Surfel& surfel = *pair.surfel;
      const float rx = pair.rx, ry = pair.ry;
      const float dx = x - surfel.x + rx, dy = y - surfel.y + ry;
      float squared = dx * dx + dy * dy;  // [m^2] residual
      if (squared > gate_squared) continue;
      float w = surfel.observations / (1.0F + surfel.observations);  // its own error beside the point's
      const bool line = surfel.isLine(), sliding = surfel.grazing && surfel.observations < grazing_observations;
      if (line || sliding) {
        float nx = surfel.nx, ny = surfel.ny;
        if (sliding) {
          // Where along the beam it was hit says nothing: it is a line along it, give or take the lidar's place in
          // base.
          const float inverse = 1.0F / std::max(1e-3F, std::hypot(rx, ry));
          nx = -ry * inverse, ny = rx * inverse;
          w *= point_weight;
        }
        const float mx = single(pair.point->normal.x()), my = single(pair.point->normal.y());
        const float facing = nx * (cosine * mx - sine * my) + ny * (sine * mx + cosine * my);
        if (facing < same_face && line && pair.point->hasNormal()) continue;
        const float e = nx * dx + ny * dy;
        squared = e * e;
        w /= 1.0F + squared * inverse_kernel;
        addRow(across, w, {nx, ny, ny * rx - nx * ry, e});
        addRow(along, w * surfel.normal_variance, {-ny, nx, nx * rx + ny * ry, 0.0F});
      } else {
        w *= point_weight / (1.0F + squared * inverse_kernel);
        addRow(across, w, {1.0F, 0.0F, -ry, dx});
        addRow(across, w, {0.0F, 1.0F, rx, dy});
      }
      weight += w;
      ++sums.equations.pairs;
      if (squared < near) {
        ++agreeing;
        agreeing_error += squared;
        observations += surfel.observations;
        known += surfel.observations >= often;
      }
    }
    rows += across.cast<double>();
    spurious += along.cast<double>();
    sums.equations.weight += weight;
    sums.observations += observations;
    sums.agreeing_error += agreeing_error;
    sums.agreeing += agreeing;
    sums.known += known;
  }
  sums.equations.H = rows.topLeftCorner<3, 3>();
  sums.equations.spurious = spurious.topLeftCorner<3, 3>();
  sums.equations.g = rows.topRightCorner<3, 1>();
  sums.equations.squared_error = rows(3, 3);
  return sums;
}

/// Points in a row that one wall or body gives. @return the first point behind those that begin at `first`
std::size_t endOfPart(std::span<const ScanPoint> points, std::size_t first, const MatchConfig& config) {
  const auto belongs = [&](std::size_t i) {
    if ((points[i].position - points[i - 1].position).norm() > config.part_gap) return false;
    const bool lines = points[i].hasNormal() && points[first].hasNormal();
    return !lines || points[i].normal.dot(points[first].normal) > config.part_bend;
  };
  std::size_t end = first + 1;
  while (end < points.size() && belongs(end)) ++end;
  return end;
}

/// How far the parts of a scan would take the pose if each were followed alone, at the pose where their pulls cancel: a
/// cluster-robust ("sandwich") covariance. Noise of single points cancels within a part; furniture that was moved, or a
/// map that is bent, does not. [Liang 1986] K.-Y. Liang and S. Zeger, "Longitudinal data analysis using generalized
/// linear models", Biometrika 73(1).
/// @param inverse of the equations, in the directions that they determine
Eigen::Matrix3d tensionAt(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T,
                          const Eigen::Matrix3d& inverse, const MatchConfig& config) {
  Eigen::Matrix3d pulls = Eigen::Matrix3d::Zero();
  for (std::size_t first = 0, end = 0; first < points.size(); first = end) {
    end = endOfPart(points, first, config);
    const Eigen::Vector3d pull = linearize(reference, points.subspan(first, end - first), T, config.final_pair_distance,
                                           config.kernel_scale, config)
                                     .equations.g;
    pulls += pull * pull.transpose();
  }
  return inverse * pulls * inverse;
}

/// Share of the promised information along `direction` that the gradient shows when the scan is displaced by a surfel
/// either way and the pairs are searched anew, 0..1. Points in a row find a partner wherever they are moved to: what
/// they seem to know of the direction along the row is not there.
double confirmedShare(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T, double gate,
                      const Eigen::Vector3d& direction, const MatchConfig& config) {
  const double distance = std::min(reference.config().surfel_spacing, config.overlap_distance);
  const auto displaced = [&](double metres) {
    const Pose2 moved = Pose2::fromVector(T.vector() + metres * direction);
    return linearize(reference, points, moved, gate, config.kernel_scale, config).equations;
  };
  const NormalEquations ahead = displaced(distance), behind = displaced(-distance);
  const double found = direction.dot(ahead.g - behind.g);
  const double promised = distance * direction.dot((ahead.H + behind.H) * direction);
  return promised > 0.0 ? std::clamp(found / promised, 0.0, 1.0) : 0.0;
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
    const Sums sums = linearize(reference, points, T, gate, kernel_scale, config);
    const NormalEquations& equations = sums.equations;
    result.pairs = equations.pairs;
    // Of the points that the reference can have: a wall beyond its window contradicts nothing.
    const double covered = std::max(1, sums.covered);
    result.overlap = static_cast<double>(sums.agreeing) / covered;
    result.known_ratio = static_cast<double>(sums.known) / covered;
    result.observations = sums.observations / std::max(1, sums.agreeing);
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

    const Eigen::Vector3d weakest = solution.weakest;
    const double confirmed = confirmedShare(reference, points, T, gate, weakest, config);
    if (confirmed < config.min_confirmed) {  // degenerate: settle once more without it
      most = solution.observable - 1;
      continue;
    }

    result.residual = std::sqrt(sums.agreeing_error / std::max(1, sums.agreeing));
    const double variance =
        std::max(config.range_sigma * config.range_sigma, equations.squared_error / equations.weight);
    // An error is the gradient's noise by its slope, and of the slope only the confirmed share is there.
    const double excess = (1.0 / (confirmed * confirmed) - 1.0) / weakest.dot(equations.H * weakest);
    result.tension = tensionAt(reference, points, T, solution.inverse, config);
    result.covariance = variance * (solution.inverse + excess * weakest * weakest.transpose()) + result.tension;
    result.directions = solution.directions;
    // Earlier iterations may have taken a direction that is degenerate for a visible one: take their steps back.
    const auto degenerate = result.directions.rightCols(3 - result.observable);
    const Eigen::Vector3d moved(T.x - guess.x, T.y - guess.y, wrapAngle(T.theta - guess.theta));
    T = Pose2::fromVector(T.vector() - degenerate * (degenerate.transpose() * moved));
    if (result.overlap < config.min_overlap) {
      result.status = MatchStatus::kLowOverlap;
    } else {
      result.status = solution.observable == 3 ? MatchStatus::kConverged : MatchStatus::kUnobservable;
    }
    return result;
  }
  result.status = MatchStatus::kIterationLimit;
  return result;
}

double overlapAt(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T_ref_base,
                 double distance, const MatchConfig& config) noexcept {
  MatchConfig near = config;
  near.overlap_distance = distance;
  const Sums sums = linearize(reference, points, T_ref_base, config.final_pair_distance, config.kernel_scale, near);
  return static_cast<double>(sums.agreeing) / std::max(1, sums.covered);
}

}  // namespace slam
