// SPDX-License-Identifier: BSD-3-Clause
#include "posegraph/place_likelihood.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_map>
#include <unordered_set>

namespace slam {
namespace {

constexpr double kSameFace = 0.2;  // cosine: a point and a wall whose normals differ by more are two faces
constexpr double kSigmas = 2.5;    // a point further from its wall did not hit it
const Eigen::Vector3d kSearchSigma(0.3, 0.3, 0.05);  // [m, m, rad] of a place that the search found
const Eigen::Vector3d kBendSigma(0.1, 0.1, 0.03);    // [m, m, rad] of the map's bend, from part to part
constexpr int kIterations = 8;
constexpr double kSettled = 0.005;  // [m] at one metre
constexpr double kFace = 0.2;       // [m] of roughness that a beam may enter before its end

using CellSet = std::unordered_set<std::int64_t>;

double sigmaOf(const BeamModel& model, double range) { return std::hypot(model.sigma, model.sigma_per_metre * range); }

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
    for (const SegmentView::Ray& ray : rays) {
      const Eigen::Vector2d p = T * ray.to, turned = p - T.translation();
      const WallField::Wall* wall = field.nearest(p);
      if (wall == nullptr || !wall->isLine()) continue;
      const Eigen::Vector2d normal = Pose2{0.0, 0.0, T.theta} * ray.normal;
      if (!ray.normal.isZero() && normal.dot(wall->normal) < kSameFace) continue;
      const double e = wall->normal.dot(p - wall->position), s = sigmaOf(model, ray.range);
      const double w = weight / (s * s * (1.0 + e * e / (s * s)));
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

struct Judged {
  double log_likelihood = 0.0;  // relative to a hit
  bool hit = false;
  const WallField::Wall* gone = nullptr;  // that the beam went through
};

Judged judge(const WallField& field, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double range,
             const BeamModel& model) {
  const double sigma = sigmaOf(model, range);
  double distance = std::numeric_limits<double>::infinity();  // [sigma]
  if (field.solid(to)) {
    distance = 0.0;
  } else if (const WallField::Wall* wall = field.nearest(to)) {
    distance = (wall->position - to).norm() / sigma;
  }
  const double peak = model.hit / (std::sqrt(2.0 * std::numbers::pi) * sigma);
  const double clutter = field.free(to) ? model.clutter_free : model.clutter_unknown;
  const double density = peak * std::exp(-0.5 * distance * distance) + clutter;
  return {std::log(std::min(1.0, density / peak)), distance < kSigmas,
          field.blocking(from, to, kSigmas * sigma + kFace)};
}

}  // namespace

void SegmentView::gather(const KeyframeGraph& keyframes, int oldest, int newest, double length, double part) {
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
    if (path >= part * static_cast<double>(parts.size())) parts.push_back({T_newest_id, {}});
    part_of.push_back(static_cast<int>(parts.size()) - 1);
    const Pose2 T_part_id = parts.back().T_newest_part.inverse() * T_newest_id;
    const Eigen::Vector2d lidar = keyframes.scan(id)->T_base_lidar.translation();
    keyframes.points(id, points);
    for (const ScanPoint& point : points) {
      const Eigen::Vector2d p = T_newest_id * point.position;
      const auto [at, is_new] = cells.try_emplace(cellOf(p, cell));
      if (!is_new && at->second.range <= point.range) continue;
      at->second = {point.range,
                    parts.size() - 1,
                    {T_part_id * lidar, T_part_id * point.position, Pose2{0.0, 0.0, T_part_id.theta} * point.normal,
                     point.range}};
    }
  }
  for (const auto& [key, nearest] : cells) parts[nearest.part].rays.push_back(nearest.ray);
  rays = static_cast<int>(cells.size());
}

PlaceFit fitPlace(const WallField& field, const SegmentView& view, const Pose2& T_map_newest, const BeamModel& model) {
  PlaceFit fit{.T_map_newest = T_map_newest};
  const double weight = std::min(1.0, view.cell / model.correlation);
  CellSet passed;  // walls that beams went through
  Pose2 T_map_part = T_map_newest;
  int seen = 0;
  for (std::size_t i = 0; i < view.parts.size(); ++i) {
    const SegmentView::Part& part = view.parts[i];
    if (i > 0) T_map_part = T_map_part * between(view.parts[i - 1].T_newest_part, part.T_newest_part);
    T_map_part = align(field, part.rays, T_map_part, i == 0 ? kSearchSigma : kBendSigma, weight, model);
    fit.T_map_part.push_back(T_map_part);
    for (const SegmentView::Ray& ray : part.rays) {
      const Judged judged = judge(field, T_map_part * ray.from, T_map_part * ray.to, ray.range, model);
      double log_likelihood = judged.log_likelihood;
      if (judged.gone == nullptr) {
        seen += judged.hit;
      } else if (passed.insert(cellOf(judged.gone->position, view.cell)).second) {
        log_likelihood += std::log(model.gone);
      }
      fit.log_likelihood += weight * log_likelihood;
    }
  }
  if (!fit.T_map_part.empty()) fit.T_map_newest = fit.T_map_part.front();
  fit.seen = static_cast<double>(seen) / std::max(1, view.rays);
  return fit;
}

}  // namespace slam
