// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/place_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace slam {
namespace {

std::int64_t cellOf(const Eigen::Vector2d& p, double cell) {
  const auto column = static_cast<std::int32_t>(std::floor(p.x() / cell));
  const auto row = static_cast<std::int32_t>(std::floor(p.y() / cell));
  return (static_cast<std::int64_t>(row) << 32) ^ static_cast<std::uint32_t>(column);
}

/// Gauss-Newton, point to line, robust, with the guess as prior.
Pose2 align(const DistanceField& field, const QueryCloud::Part& part, const Pose2& guess, const Eigen::Vector3d& sigma,
            double weight, const BeamModel& model, const PlaceFitConfig& config) {
  Pose2 T = guess;
  for (int i = 0; i < config.iterations; ++i) {
    Eigen::Matrix3d H = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    const Eigen::Vector3d error(T.x - guess.x, T.y - guess.y, wrapAngle(T.theta - guess.theta));
    Eigen::Vector3d g = H * error;
    const PointTransform T_map_part(T);
    for (const QueryCloud::Ray& ray : part.rays) {
      const Eigen::Vector2d p = T_map_part * ray.to, turned = p - T.translation();
      const DistanceField::Wall* wall = field.nearest(p);
      if (wall == nullptr || !wall->isLine()) continue;
      if (!ray.normal.isZero() && wall->normal.dot(T_map_part.turned(ray.normal)) < config.same_face) continue;
      const double e = wall->normal.dot(p - wall->position),
                   bend = config.bent_per_metre * (ray.range - part.least_range);
      const double w = weight / (model.sigma * model.sigma + bend * bend + e * e);
      const Eigen::Vector3d J(wall->normal.x(), wall->normal.y(),
                              wall->normal.y() * turned.x() - wall->normal.x() * turned.y());
      H += w * J * J.transpose();
      g += w * e * J;
    }
    const Eigen::Vector3d step = H.ldlt().solve(-g);
    T = {T.x + step.x(), T.y + step.y(), wrapAngle(T.theta + step.z())};
    if (step.head<2>().norm() + std::abs(step.z()) < config.settled) break;
  }
  return T;
}

double logEnds(const DecayRateMap& field, const QueryCloud::Part& part, const Pose2& T_map_part) {
  const PointTransform T(T_map_part);
  double sum = 0.0;
  for (const QueryCloud::Ray& ray : part.rays) sum += field.logRate(T * ray.to, ray.range);
  return sum;
}

/// The offset [m, m, rad] of which the log-likelihood of the beams' ends and of the offset itself is highest.
template <typename LogEnds>
Pose2 likeliest(const PlaceFitConfig::Steps& steps, const Pose2& centre, const Eigen::Vector3d& sigma,
                LogEnds&& log_ends) {
  Pose2 best = centre;
  double highest = -std::numeric_limits<double>::infinity();
  for (int t = -steps.turns; t <= steps.turns; ++t) {
    for (int r = -steps.reach; r <= steps.reach; ++r) {
      for (int c = -steps.reach; c <= steps.reach; ++c) {
        const Pose2 by{centre.x + c * steps.step, centre.y + r * steps.step, centre.theta + t * steps.turn};
        const Eigen::Vector3d off = Eigen::Vector3d(by.x, by.y, by.theta).cwiseQuotient(sigma);
        const double log_likelihood = log_ends(by) - 0.5 * off.squaredNorm();
        if (log_likelihood <= highest) continue;
        highest = log_likelihood;
        best = by;
      }
    }
  }
  return best;
}

Pose2 moved(const Pose2& T, const Pose2& by) { return {T.x + by.x, T.y + by.y, wrapAngle(T.theta + by.theta)}; }

/// Moves all parts together to where the beams end most likely, and then each that was seen in a distance by itself:
/// along a corridor a few beams decide, which a robust match of all points leaves where it found them.
void settle(const DecayRateMap& field, const QueryCloud& view, double weight, const PlaceFitConfig& config,
            std::vector<Pose2>& T_map_part) {
  const Pose2 T_map_newest = T_map_part.front();
  const auto together = [&](const Pose2& by) {  // about the newest pose
    return moved(T_map_newest, by) * T_map_newest.inverse();
  };
  const auto log_ends = [&](const Pose2& by) {
    const Pose2 move = together(by);
    double sum = 0.0;
    for (std::size_t i = 0; i < view.parts.size(); ++i) sum += logEnds(field, view.parts[i], move * T_map_part[i]);
    return weight * sum;
  };
  const Pose2 coarse = likeliest(config.together, {}, config.search_sigma, log_ends);
  const Pose2 move = together(likeliest(config.together_fine, coarse, config.search_sigma, log_ends));
  for (std::size_t i = 0; i < view.parts.size(); ++i) {
    Pose2& T_map = T_map_part[i];
    T_map = move * T_map;
    if (view.parts[i].least_range <= 0.0) continue;
    T_map = moved(T_map, likeliest(config.ahead, {}, config.ahead_sigma, [&](const Pose2& by) {
                    return weight * logEnds(field, view.parts[i], moved(T_map, by));
                  }));
  }
}

}  // namespace

void QueryCloud::gather(const KeyframeGraph& keyframes, int oldest, int newest, double length, double part,
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

/// Where a map bends, a part that fits the walls around the robot misses those far ahead: they are turned about the
/// joint between them, which lies amid the rays, as far away as the nearest of them may be.
void QueryCloud::splitByRange(double rigid_range) {
  for (std::size_t i = 0; i < parts.size(); ++i) {  // those that are added, too
    const double least = parts[i].least_range + rigid_range;
    std::vector<Ray>& near = parts[i].rays;
    const auto far = std::stable_partition(near.begin(), near.end(), [&](const Ray& ray) { return ray.range < least; });
    if (far == near.end()) continue;
    Part ahead{parts[i].T_newest_part, {far, near.end()}, static_cast<int>(i), least};
    near.erase(far, near.end());
    Eigen::Vector2d direction = Eigen::Vector2d::Zero();
    for (const Ray& ray : ahead.rays) direction += (ray.to - ray.from) / ray.range;
    const Eigen::Vector2d joint = least / static_cast<double>(ahead.rays.size()) * direction;
    ahead.T_newest_part = ahead.T_newest_part * Pose2{joint.x(), joint.y(), 0.0};
    for (Ray& ray : ahead.rays) {
      ray.from -= joint;
      ray.to -= joint;
    }
    parts.push_back(std::move(ahead));
  }
}

QueryCloud QueryCloud::scaled(double scale) const {
  QueryCloud view = *this;
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

PlaceFit fitPlace(const DecayRateMap& field, const QueryCloud& view, const Pose2& T_map_newest,
                  const PlaceFitConfig& config) {
  PlaceFit fit{.T_map_newest = T_map_newest};
  if (view.parts.empty()) return fit;
  const BeamModel& model = field.model();
  const double weight = view.weight(model);
  std::vector<Pose2> T_map_part;
  for (const QueryCloud::Part& part : view.parts) {
    Pose2 guess = T_map_newest;
    const Eigen::Vector3d* sigma = &config.search_sigma;
    if (part.beside >= 0) {
      const auto beside = static_cast<std::size_t>(part.beside);
      guess = T_map_part[beside] * between(view.parts[beside].T_newest_part, part.T_newest_part);
      sigma = part.least_range > 0.0 ? &config.ahead_sigma : &config.bend_sigma;
    }
    T_map_part.push_back(align(field.walls(), part, guess, *sigma, weight, model, config));
  }
  settle(field, view, weight, config, T_map_part);
  fit.T_map_newest = T_map_part.front();

  std::vector<DecayRateMap::Passed> passed;
  int seen = 0;
  for (std::size_t i = 0; i < view.parts.size(); ++i) {
    const PointTransform T(T_map_part[i]);
    for (const QueryCloud::Ray& ray : view.parts[i].rays) {
      const Eigen::Vector2d to = T * ray.to;
      const double log_rate = field.logRate(to, ray.range);
      const bool through = field.pass(T * ray.from, to, passed) < config.through * model.logThrough();
      fit.log_likelihood +=
          weight * (through && model.stale_free_space ? std::max(log_rate, field.logRateUnknown()) : log_rate);
      seen += field.atWall(log_rate) && !through;
    }
  }
  fit.log_likelihood += field.logPassed(passed);
  fit.seen = static_cast<double>(seen) / std::max(1, view.rays);
  return fit;
}

}  // namespace slam
