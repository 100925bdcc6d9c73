// SPDX-License-Identifier: BSD-3-Clause
#include "depth/floor_tracker.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace slam {
namespace {

constexpr int kIterations = 4;
constexpr std::size_t kCounted = 4;  // every so many points are asked whether they lie on a plane

}  // namespace

FloorTracker::Fit FloorTracker::fitNear(const std::vector<Eigen::Vector3f>& points, const FloorPlane& guess) const {
  Fit fit{guess};
  for (int i = 0; i < kIterations; ++i) {
    const double narrow = static_cast<double>(i) / (kIterations - 1);
    const double gate = std::lerp(config_.gate, config_.final_gate, narrow);
    const double slope = std::lerp(last_ ? config_.gate_slope : config_.max_tilt, config_.final_gate_slope, narrow);
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    fit.points = 0;
    Eigen::Vector2d spread = Eigen::Vector2d::Zero();  // sum of x, of x^2
    for (const Eigen::Vector3f& p : points) {
      const double e = p.z() - fit.plane.height(p.x(), p.y());
      if (std::abs(e) > gate + slope * p.x()) continue;
      const Eigen::Vector3d J(1.0, p.x(), p.y());
      H += J * J.transpose();
      g += e * J;
      spread += Eigen::Vector2d(p.x(), p.x() * p.x());
      ++fit.points;
    }
    if (fit.points < config_.min_points) return fit;
    const double weight = std::min(1.0, static_cast<double>(config_.independent) / fit.points) /
                          (config_.point_sigma * config_.point_sigma);
    const Eigen::Vector3d prior(1.0 / (config_.prior_offset * config_.prior_offset),
                                1.0 / (config_.prior_slope * config_.prior_slope),
                                1.0 / (config_.prior_slope * config_.prior_slope));
    const Eigen::Vector3d off(fit.plane.offset - guess.offset, fit.plane.slope_x - guess.slope_x,
                              fit.plane.slope_y - guess.slope_y);
    const Eigen::Vector3d mount(1.0 / (config_.mount_offset * config_.mount_offset),
                                1.0 / (config_.mount_slope * config_.mount_slope),
                                1.0 / (config_.mount_slope * config_.mount_slope));
    const Eigen::Vector3d whole(fit.plane.offset, fit.plane.slope_x, fit.plane.slope_y);
    H *= weight;
    H.diagonal() += prior + mount;
    const Eigen::Vector3d step = H.ldlt().solve(weight * g - prior.cwiseProduct(off) - mount.cwiseProduct(whole));
    fit.plane.offset += step.x();
    fit.plane.slope_x += step.y();
    fit.plane.slope_y += step.z();
    fit.extent = std::sqrt(std::max(0.0, spread.y() / fit.points - std::pow(spread.x() / fit.points, 2)));
  }
  return fit;
}

std::optional<double> FloorTracker::update(Timestamp stamp, const std::vector<Eigen::Vector3f>& points,
                                           double camera_height) {
  const Fit fit = fitNear(points, plane_);
  const bool inside = fit.plane.tilt() <= config_.max_tilt && std::abs(fit.plane.offset) <= config_.max_offset;
  if (!inside || fit.points < config_.scarce * static_cast<double>(points.size())) {
    const Search found = findElsewhere(points, camera_height, inside ? fit.points : 0);
    if (found.tilt) return found.tilt;
    if (found.level) {  // the floor is where the mount has it, only the plane was not
      plane_ = {};
      return std::nullopt;
    }
  }
  if (fit.points < config_.min_points || fit.extent < config_.narrow) return std::nullopt;
  // Bounded, towards where it was found.
  const double share = last_ ? std::clamp(toSeconds(stamp - *last_) / config_.settle_time, 0.0, 1.0) : 1.0;
  last_ = stamp;
  FloorPlane target = fit.plane;
  target.offset = std::clamp(target.offset, -config_.max_offset, config_.max_offset);
  if (const double tilt = target.tilt(); tilt > config_.max_tilt) {
    target.slope_x *= config_.max_tilt / tilt;
    target.slope_y *= config_.max_tilt / tilt;
  }
  plane_.offset += share * (target.offset - plane_.offset);
  plane_.slope_x += share * (target.slope_x - plane_.slope_x);
  plane_.slope_y += share * (target.slope_y - plane_.slope_y);
  return std::nullopt;
}

/// RANSAC: a plane at about the floor's distance from the camera that holds most of what the camera sees.
/// [Fischler 1981] M. Fischler and R. Bolles, "Random sample consensus", Comm. ACM 24(6).
FloorTracker::Search FloorTracker::findElsewhere(const std::vector<Eigen::Vector3f>& points, double camera_height,
                                                 int points_of_floor) const {
  Search found;
  if (static_cast<int>(points.size()) < 4 * config_.min_points) return found;
  std::minstd_rand random(1);  // the same for the same image
  std::uniform_int_distribution<std::size_t> pick(0, points.size() - 1);
  const Eigen::Vector3d camera(0.0, 0.0, camera_height);
  int most = std::max(2 * points_of_floor, static_cast<int>(config_.dominant * static_cast<double>(points.size())));
  for (int i = 0; i < config_.hypotheses; ++i) {
    const Eigen::Vector3d a = points[pick(random)].cast<double>();
    const Eigen::Vector3d b = points[pick(random)].cast<double>(), c = points[pick(random)].cast<double>();
    Eigen::Vector3d normal = (b - a).cross(c - a);
    if (normal.norm() < 0.05) continue;  // [m^2] three points too close together
    normal.normalize();
    const double lean = std::acos(std::min(1.0, std::abs(normal.z())));
    const double distance = std::abs(normal.dot(camera - a));
    if (lean > config_.max_lean || distance < config_.nearest * camera_height ||
        distance > config_.farthest * camera_height) {
      continue;
    }
    // Above, where the camera is: as of a camera on its head. A floor that rises may be so further on.
    const bool level = lean <= config_.max_tilt, above = normal.dot(a) / normal.z() > camera_height;
    // A level plane may be a table; it is taken for the floor only where no other floor is seen.
    // Clearly level: of a camera just beyond the bound a plane just within it holds nearly as much.
    const bool in_place =
        lean <= config_.level * config_.max_tilt && !above && std::abs(distance - camera_height) <= config_.max_offset;
    const bool elsewhere =
        std::abs(distance - camera_height) > 2.0 * config_.max_offset && points_of_floor < config_.min_points;
    if (level && !above && !elsewhere && !in_place) continue;
    int inliers = 0;
    for (std::size_t k = 0; k < points.size(); k += kCounted) {
      const Eigen::Vector3f& p = points[k];
      inliers += std::abs(normal.dot(p.cast<double>() - a)) < config_.thickness + config_.thickness_slope * p.x();
    }
    inliers *= static_cast<int>(kCounted);
    if (inliers <= most) continue;
    most = inliers;
    found.level = in_place;
    found.tilt = in_place ? std::nullopt : std::optional(above ? std::numbers::pi - lean : lean);
  }
  return found;
}

}  // namespace slam
