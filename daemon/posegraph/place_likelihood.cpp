// SPDX-License-Identifier: BSD-3-Clause
#include "posegraph/place_likelihood.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace slam {
namespace {

constexpr double kSameFace = 0.2;  // cosine: a point and a wall whose normals differ by more are two faces
const Eigen::Vector3d kSearchSigma(0.3, 0.3, 0.05);  // [m, m, rad] of a place that the search found
const Eigen::Vector3d kBendSigma(0.1, 0.1, 0.03);    // [m, m, rad] of the map's bend, from part to part of the path
const Eigen::Vector3d kAheadSigma(0.1, 0.1, 0.015);  // [m, m, rad] ... and to what was seen in a distance
constexpr double kBentPerMetre = 0.02;               // [1] before a part is laid
constexpr int kIterations = 8;
constexpr double kSettled = 0.005;  // [m] at one metre
constexpr int kReach = 2;           // steps to each side that a place is moved at most
constexpr double kStep = 0.2;       // [m]
constexpr double kTurn = 0.01;      // [rad]
constexpr double kThrough = 0.5;    // [1] of a wall: a beam that went through more did not end at the map's first wall

std::int64_t cellOf(const Eigen::Vector2d& p, double cell) {
  const auto column = static_cast<std::int32_t>(std::floor(p.x() / cell));
  const auto row = static_cast<std::int32_t>(std::floor(p.y() / cell));
  return (static_cast<std::int64_t>(row) << 32) ^ static_cast<std::uint32_t>(column);
}

/// Gauss-Newton, point to line, robust, with the guess as prior.
Pose2 align(const WallField& field, std::span<const SegmentView::Ray> rays, const Pose2& guess,
            const Eigen::Vector3d& sigma, double weight, const BeamModel& model) {
  Pose2 T = guess;
  for (int i = 0; i < kIterations; ++i) {
    Eigen::Matrix3d H = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    const Eigen::Vector3d error(T.x - guess.x, T.y - guess.y, wrapAngle(T.theta - guess.theta));
    Eigen::Vector3d g = H * error;
    const PointTransform T_map_part(T);
    for (const SegmentView::Ray& ray : rays) {
      const Eigen::Vector2d p = T_map_part * ray.to, turned = p - T.translation();
      const WallField::Wall* wall = field.nearest(p);
      if (wall == nullptr || !wall->isLine()) continue;
      if (!ray.normal.isZero() && wall->normal.dot(T_map_part.turned(ray.normal)) < kSameFace) continue;
      const double e = wall->normal.dot(p - wall->position), bend = kBentPerMetre * ray.range;
      const double w = weight / (model.sigma * model.sigma + bend * bend + e * e);
      const Eigen::Vector3d J(wall->normal.x(), wall->normal.y(),
                              wall->normal.y() * turned.x() - wall->normal.x() * turned.y());
      H += w * J * J.transpose();
      g += w * e * J;
    }
    const Eigen::Vector3d step = H.ldlt().solve(-g);
    T = {T.x + step.x(), T.y + step.y(), wrapAngle(T.theta + step.z())};
    if (step.head<2>().norm() + std::abs(step.z()) < kSettled) break;
  }
  return T;
}

double logEnds(const DecayField& field, const SegmentView& view, std::span<const Pose2> T_map_part, const Pose2& move) {
  double sum = 0.0;
  for (std::size_t i = 0; i < view.parts.size(); ++i) {
    const PointTransform T(move * T_map_part[i]);
    for (const SegmentView::Ray& ray : view.parts[i].rays) sum += field.logRate(T * ray.to, ray.range);
  }
  return sum;
}

/// Moves all parts together to where the beams end most likely: along a corridor a few of them decide, which a robust
/// match of all points leaves where it found them.
void settle(const DecayField& field, const SegmentView& view, double weight, std::vector<Pose2>& T_map_part) {
  const Pose2 T_map_newest = T_map_part.front();
  const auto moved = [&](const Pose2& by) {  // about the newest pose
    const Pose2 T{T_map_newest.x + by.x, T_map_newest.y + by.y, wrapAngle(T_map_newest.theta + by.theta)};
    return T * T_map_newest.inverse();
  };
  Pose2 best;
  double highest = -std::numeric_limits<double>::infinity();
  const auto look = [&](const Pose2& centre, int reach, double step, double turn) {
    for (int t = -1; t <= 1; ++t) {
      for (int r = -reach; r <= reach; ++r) {
        for (int c = -reach; c <= reach; ++c) {
          const Pose2 by{centre.x + c * step, centre.y + r * step, centre.theta + t * turn};
          const Eigen::Vector3d off = Eigen::Vector3d(by.x, by.y, by.theta).cwiseQuotient(kSearchSigma);
          const double log_likelihood = weight * logEnds(field, view, T_map_part, moved(by)) - 0.5 * off.squaredNorm();
          if (log_likelihood <= highest) continue;
          highest = log_likelihood;
          best = by;
        }
      }
    }
  };
  look({}, kReach, kStep, kTurn);
  look(best, 1, 0.5 * kStep, 0.5 * kTurn);
  const Pose2 move = moved(best);
  for (Pose2& T_map : T_map_part) T_map = move * T_map;
}

}  // namespace

void SegmentView::gather(const KeyframeGraph& keyframes, int oldest, int newest, double length, double part,
                         double rigid_range) {
  struct Nearest {
    double range;
    std::size_t part;
    Ray ray;
  };
  std::unordered_map<std::int64_t, Nearest> cells;
  const Pose2 T_newest_map = keyframes.pose(newest).inverse();
  ScanPoints points;
  parts.clear();
  part_of.clear();
  double path = 0.0;
  for (int id = newest; id >= oldest; --id) {
    if (id < newest) path += (keyframes.pose(id).translation() - keyframes.pose(id + 1).translation()).norm();
    if (path > length) break;
    const Pose2 T_newest_id = T_newest_map * keyframes.pose(id);
    const PointTransform in_newest(T_newest_id);
    if (path >= part * static_cast<double>(parts.size())) {
      parts.push_back({.T_newest_part = T_newest_id, .rays = {}, .beside = static_cast<int>(parts.size()) - 1});
    }
    part_of.push_back(static_cast<int>(parts.size()) - 1);
    const PointTransform T_part_id(parts.back().T_newest_part.inverse() * T_newest_id);
    const Eigen::Vector2d lidar = keyframes.scan(id)->T_base_lidar.translation();
    keyframes.points(id, points);
    for (const ScanPoint& point : points) {
      const Eigen::Vector2d p = in_newest * point.position;
      const auto [at, is_new] = cells.try_emplace(cellOf(p, cell));
      if (!is_new && at->second.range <= point.range) continue;
      at->second = {point.range,
                    parts.size() - 1,
                    {T_part_id * lidar, T_part_id * point.position, T_part_id.turned(point.normal), point.range}};
    }
  }
  for (const auto& [key, nearest] : cells) parts[nearest.part].rays.push_back(nearest.ray);
  rays = static_cast<int>(cells.size());
  if (rigid_range > 0.0) splitByRange(rigid_range);
}

/// Where a map bends, a part that fits the walls around the robot misses those far ahead.
void SegmentView::splitByRange(double rigid_range) {
  for (std::size_t i = 0; i < parts.size(); ++i) {  // those that are added, too
    const double least = parts[i].least_range + rigid_range;
    std::vector<Ray>& near = parts[i].rays;
    const auto far = std::stable_partition(near.begin(), near.end(), [&](const Ray& ray) { return ray.range < least; });
    if (far == near.end()) continue;
    Part ahead{parts[i].T_newest_part, {far, near.end()}, static_cast<int>(i), least};
    near.erase(far, near.end());
    parts.push_back(std::move(ahead));
  }
}

SegmentView SegmentView::scaled(double scale) const {
  SegmentView view = *this;
  for (Part& part_of_path : view.parts) {
    part_of_path.T_newest_part.x *= scale;
    part_of_path.T_newest_part.y *= scale;
    for (Ray& ray : part_of_path.rays) {
      ray.from *= scale;
      ray.to *= scale;
      ray.range *= scale;
    }
  }
  return view;
}

PlaceFit fitPlace(const DecayField& field, const SegmentView& view, const Pose2& T_map_newest) {
  PlaceFit fit{.T_map_newest = T_map_newest};
  if (view.parts.empty()) return fit;
  const BeamModel& model = field.model();
  const double weight = std::min(1.0, view.cell / model.correlation);
  std::vector<Pose2> T_map_part;
  for (const SegmentView::Part& part : view.parts) {
    Pose2 guess = T_map_newest;
    const Eigen::Vector3d* sigma = &kSearchSigma;
    if (part.beside >= 0) {
      const auto beside = static_cast<std::size_t>(part.beside);
      guess = T_map_part[beside] * between(view.parts[beside].T_newest_part, part.T_newest_part);
      sigma = part.least_range > 0.0 ? &kAheadSigma : &kBendSigma;
    }
    T_map_part.push_back(align(field.walls(), part.rays, guess, *sigma, weight, model));
  }
  settle(field, view, weight, T_map_part);
  fit.T_map_newest = T_map_part.front();

  std::vector<DecayField::Passed> passed;
  int seen = 0;
  for (std::size_t i = 0; i < view.parts.size(); ++i) {
    const PointTransform T(T_map_part[i]);
    for (const SegmentView::Ray& ray : view.parts[i].rays) {
      const Eigen::Vector2d to = T * ray.to;
      const double log_rate = field.logRate(to, ray.range);
      const bool through = field.pass(T * ray.from, to, passed) < kThrough * model.logThrough();
      fit.log_likelihood += weight * (through && model.doubted ? std::max(log_rate, field.logRateUnknown()) : log_rate);
      seen += field.atWall(log_rate) && !through;
    }
  }
  fit.log_likelihood += field.logPassed(passed);
  fit.seen = static_cast<double>(seen) / std::max(1, view.rays);
  return fit;
}

}  // namespace slam
