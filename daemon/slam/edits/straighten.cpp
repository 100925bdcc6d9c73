// SPDX-License-Identifier: BSD-3-Clause
#include "slam/edits/straighten.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "problems/answer.hpp"
#include "problems/answers.hpp"

namespace slam {
namespace {

struct Normal {
  double angle;   // [rad] in map
  double weight;  // [1/rad^2]
};

/// [rad] walls meet at right angles
constexpr double quarter() { return 0.5 * std::numbers::pi; }

std::vector<Normal> normalsOf(const MapState& map, double noise) {
  std::vector<Normal> normals;
  for (int id = 0; id < map.keyframes.size(); ++id) {
    if (map.in_map[static_cast<std::size_t>(id)] == 0) continue;
    for (const Keyframe::Point& point : map.keyframes.scan(id)->points) {
      if (point.normal == Keyframe::Point::kNoNormal) continue;
      const double sigma = std::max<double>(point.normal_sigma, 1.0) * Keyframe::Point::kAngle;
      normals.push_back({map.keyframes.pose(id).theta + point.normal * Keyframe::Point::kAngle,
                         1.0 / (sigma * sigma + noise * noise)});
    }
  }
  return normals;
}

/// [rad] to the nearest multiple of a quarter turn
double fromQuarter(double angle) { return std::remainder(angle, quarter()); }

}  // namespace

std::optional<double> headingOfWalls(const MapState& map, const StraightenConfig& config) {
  const std::vector<Normal> normals = normalsOf(map, config.noise);
  if (normals.size() < config.fewest) return std::nullopt;
  std::vector<double> bins(static_cast<std::size_t>(std::ceil(quarter() / config.bin)), 0.0);
  const auto count = std::ssize(bins);
  for (const Normal& normal : normals) {
    const double share = (fromQuarter(normal.angle) + 0.5 * quarter()) / quarter();
    bins[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(
        static_cast<std::ptrdiff_t>(share * static_cast<double>(count)), 0, count - 1))] += normal.weight;
  }
  const auto peak = std::max_element(bins.begin(), bins.end()) - bins.begin();
  double heading = quarter() * ((static_cast<double>(peak) + 0.5) / static_cast<double>(count) - 0.5);
  for (int round = 0; round < config.rounds; ++round) {
    double sum = 0.0, weights = 0.0;
    for (const Normal& normal : normals) {
      const double off = fromQuarter(normal.angle - heading);
      if (std::abs(off) > config.around) continue;
      sum += normal.weight * off;
      weights += normal.weight;
    }
    if (weights > 0.0) heading += sum / weights;
  }
  heading = fromQuarter(heading);
  // A wall along x has its normal along y.
  double along_x = 0.0, along_y = 0.0;
  for (const Normal& normal : normals) {
    const double off = normal.angle - heading;
    if (std::abs(fromQuarter(off)) <= config.around)
      (std::abs(std::sin(off)) > 0.5 ? along_x : along_y) += normal.weight;
  }
  if (along_y <= config.clearly * along_x) return heading;
  return heading > 0.0 ? heading - quarter() : heading + quarter();
}

MapState transformed(const MapState& map, const Pose2& T_new_map, const OccupancyGridConfig& config) {
  MapState moved = map.clone();
  for (int id = 0; id < map.keyframes.size(); ++id)
    moved.keyframes.graph().setPose(id, T_new_map * map.keyframes.pose(id));
  for (MapEdit& edit : moved.edits.edits) edit.sigma = turnedSigma(edit.sigma, T_new_map.theta);
  ++moved.edits.revision;
  moved.T_map_base = T_new_map * map.T_map_base;
  OccupancyGridConfig same = config;
  same.resolution = map.grid.resolution();
  moved.grid = drawGrid(moved, same);
  moved.grid_keyframes = moved.keyframes.size();
  return moved;
}

Pose2 straightFrame(const MapState& map, const std::string& origin) {
  const auto heading = headingOfWalls(map);
  if (!heading) throw CommandRefused(answer::kFewWalls);
  Pose2 T_map_new{0.0, 0.0, *heading};
  if (!origin.empty()) {
    const auto& edits = map.edits.edits;
    const auto place = std::find_if(edits.rbegin(), edits.rend(), [&](const MapEdit& edit) {
      return edit.active && edit.kind == EditKind::kPlace && edit.name == origin &&
             !pointsOf(edit, map.keyframes, map.in_map).empty();
    });
    if (place == edits.rend()) throw CommandRefused({answer::kNoPlace, {}, {origin}});
    const Pose2 T_map_place = poseOf(*place, map.keyframes);
    T_map_new.x = T_map_place.x;
    T_map_new.y = T_map_place.y;
  }
  return T_map_new.inverse();
}

}  // namespace slam
