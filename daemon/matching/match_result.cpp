// SPDX-License-Identifier: BSD-3-Clause
#include "matching/match_result.hpp"

#include <Eigen/Geometry>

namespace slam {

MatchResult projectedOut(const MatchResult& match, const Eigen::Vector2d& guess, const Eigen::Vector2d& direction) {
  constexpr double kLeast = 0.3;  // [1] of a unit direction that must be left for it to be one
  const Eigen::Vector3d held(direction.x(), direction.y(), 0.0);
  const Eigen::Vector2d matched = match.T_ref_base.translation();
  const Eigen::Vector2d position = matched - direction * direction.dot(matched - guess);
  MatchResult result = match;
  result.T_ref_base = {position.x(), position.y(), match.T_ref_base.theta};
  result.status = MatchStatus::kUnobservable;
  result.observable = 0;
  Eigen::Matrix3d& directions = result.directions;
  for (int i = 0; i < match.observable && result.observable < 2; ++i) {
    Eigen::Vector3d rest = match.directions.col(i);
    rest -= held * held.dot(rest);
    const auto found = directions.leftCols(result.observable);
    rest -= (found * (found.transpose() * rest)).eval();
    if (rest.norm() > kLeast) directions.col(result.observable++) = rest.normalized();
  }
  int column = result.observable;
  directions.col(column++) = held;
  if (column == 1) directions.col(column++) = Eigen::Vector3d(-held.y(), held.x(), 0.0);
  if (column == 2) directions.col(2) = directions.col(0).cross(directions.col(1));
  return result;
}

}  // namespace slam
