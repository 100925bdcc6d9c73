// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/wall_extrapolation.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

namespace slam {
namespace {

using Known = DistanceField::Known;

constexpr double kTolerances[] = {0.4, 0.25, 0.15};  // [m] of a wall's points from its line, fitted again and again

struct Line {
  Eigen::Vector2d end, along;  // [m] foot of the wall's last point; unit, onward
};

Known knownAt(const DistanceField& walls, const Eigen::Vector2d& p) {
  const auto i = walls.index(p);
  return i < 0 ? Known::kNothing : walls.known(static_cast<std::size_t>(i));
}

/// The line of a wall before its point `last`, if it is straight there.
std::optional<Line> straightBefore(const DistanceField& walls, const DistanceField::Wall& last,
                                   const Eigen::Vector2d& onward, const WallExtrapolationConfig& config) {
  const double cell = walls.cell();
  Line line{last.position, onward};
  for (const double tolerance : kTolerances) {
    const Eigen::Vector2d across(-line.along.y(), line.along.x());
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();  // [m] from the last point
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    int count = 0;
    for (double s = 0.0; s <= config.straight; s += cell) {
      const Eigen::Vector2d p = line.end - s * line.along;
      const DistanceField::Wall* wall = walls.nearest(p);
      if (wall == nullptr || (wall->isLine() && wall->normal.dot(last.normal) < config.same_face)) continue;
      const Eigen::Vector2d off = wall->position - p, from_last = wall->position - last.position;
      if (std::abs(off.dot(across)) > tolerance || std::abs(off.dot(line.along)) > 1.5 * cell) continue;
      sum += from_last;
      squares += from_last * from_last.transpose();
      ++count;
    }
    if (count * cell < config.share * config.straight) return std::nullopt;
    const Eigen::Vector2d mean = sum / count;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> spread(squares / count - mean * mean.transpose());
    if (tolerance == *std::rbegin(kTolerances) && spread.eigenvalues()(0) > config.spread * config.spread)
      return std::nullopt;
    const Eigen::Vector2d along = spread.eigenvectors().col(1);
    line.along = along.dot(line.along) < 0.0 ? Eigen::Vector2d(-along) : along;
    line.end = last.position + mean - mean.dot(line.along) * line.along;
  }
  return line;
}

/// Way [m] from the end of a wall to the map's rim, if it is the rim that ends it.
std::optional<double> toRim(const DistanceField& walls, const Line& line, const Eigen::Vector2d& facing,
                            const WallExtrapolationConfig& config) {
  for (double s = config.end; s <= config.gap; s += walls.cell()) {
    const Eigen::Vector2d p = line.end + s * line.along;
    const Known beside = knownAt(walls, p + config.beside * facing);
    if (knownAt(walls, p) == Known::kSolid || beside == Known::kSolid) return std::nullopt;
    if (beside == Known::kNothing) return s;
  }
  return std::nullopt;
}

}  // namespace

std::vector<std::size_t> extrapolatedWalls(const DistanceField& walls, const WallExtrapolationConfig& config) {
  const double step = 0.5 * walls.cell(), half = 0.5 * walls.thickness();
  std::vector<std::size_t> cells;
  for (const DistanceField::Wall& last : walls.walls()) {
    if (!last.isLine()) continue;
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector2d onward(-side * last.normal.y(), side * last.normal.x());
      if (knownAt(walls, last.position + config.end * onward) == Known::kSolid)
        continue;  // most of them, at little cost
      const auto line = straightBefore(walls, last, onward, config);
      if (!line) continue;
      const Eigen::Vector2d across(-line->along.y(), line->along.x());
      const auto rim = toRim(walls, *line, last.normal.dot(across) < 0.0 ? Eigen::Vector2d(-across) : across, config);
      if (!rim) continue;
      for (double s = *rim; s <= config.length; s += step) {
        const Eigen::Vector2d p = line->end + s * line->along;
        if (knownAt(walls, p) == Known::kFree) break;
        for (double offset = -half; offset <= half; offset += step) {
          const auto cell = walls.index(p + offset * across);
          if (cell < 0 || walls.known(static_cast<std::size_t>(cell)) != Known::kNothing) continue;
          cells.push_back(static_cast<std::size_t>(cell));
        }
      }
    }
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

}  // namespace slam
