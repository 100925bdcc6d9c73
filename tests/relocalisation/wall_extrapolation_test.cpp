// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/wall_extrapolation.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <random>

namespace slam::test::wall_extrapolation_test {
namespace {

using Known = DistanceField::Known;

constexpr double kCell = 0.1;     // [m]
constexpr double kMargin = 10.0;  // [m]

/// A floor plan: what is known at each place of a square of 20 m, walls with normals to free space.
DistanceField planOf(const std::function<Known(const Eigen::Vector2d&)>& known) {
  auto scan = std::make_shared<StoredScan>();
  const auto centre = [](int column, int row) { return Eigen::Vector2d((column + 0.5) * kCell, (row + 0.5) * kCell); };
  for (int row = -100; row < 100; ++row) {
    for (int column = -100; column < 100; ++column) {
      const Eigen::Vector2d p = centre(column, row);
      if (known(p) == Known::kFree) scan->free.push_back(p.cast<float>());
      if (known(p) != Known::kSolid) continue;
      Eigen::Vector2d to_free = Eigen::Vector2d::Zero();
      bool face = false;
      for (int r = -2; r <= 2; ++r) {
        for (int c = -2; c <= 2; ++c) {
          if (known(centre(column + c, row + r)) != Known::kFree) continue;
          to_free += Eigen::Vector2d(c, r);
          face |= std::abs(r) + std::abs(c) == 1;
        }
      }
      if (!face) {
        scan->solid.push_back(p.cast<float>());
        continue;
      }
      const double angle = std::atan2(to_free.y(), to_free.x());
      scan->points.push_back({.x = static_cast<float>(p.x()),
                              .y = static_cast<float>(p.y()),
                              .normal = static_cast<std::int16_t>(std::lround(angle / Keyframe::Point::kAngle)),
                              .normal_sigma = 100});
    }
  }
  KeyframeGraph keyframes;
  keyframes.add(scan, {});
  const int all[] = {0};
  return DistanceField(keyframes, all, {.kind = MapKind::kFloorPlan, .margin = kMargin});
}

/// A corridor 2 m wide and seen up to x = 4 m, of walls 0.2 m thick that are drawn up to `wall_end` [m].
Known corridor(const Eigen::Vector2d& p, double wall_end) {
  if (p.x() > 4.0) return Known::kNothing;
  if (std::abs(p.y()) < 1.0) return Known::kFree;
  return std::abs(p.y()) < 1.2 && p.x() < wall_end ? Known::kSolid : Known::kNothing;
}

std::vector<Eigen::Vector2d> continued(const DistanceField& walls) {
  std::vector<Eigen::Vector2d> places;
  for (const std::size_t cell : extrapolatedWalls(walls)) {
    EXPECT_EQ(walls.known(cell), Known::kNothing);
    const auto columns = static_cast<std::size_t>(walls.columns());
    const Eigen::Vector2d first = walls.walls().front().position;  // amid its cell
    const auto at = static_cast<std::size_t>(walls.index(first));
    const auto steps = [](std::size_t to, std::size_t from) {
      return static_cast<double>(to) - static_cast<double>(from);
    };
    places.push_back(first + walls.cell() * Eigen::Vector2d(steps(cell % columns, at % columns),
                                                            steps(cell / columns, at / columns)));
  }
  return places;
}

/// Drawn by a robot that turned round in it: walls that noise moved by a cell, seen late at a grazing angle.
TEST(WallExtrapolation, ACorridorGoesOnBeyondTheRim) {
  for (const double turn : {0.0, 0.1, -0.7}) {
    for (const double wall_end : {3.9, 2.0}) {
      std::mt19937 generator(3);
      std::uniform_real_distribution<double> noise(-0.06, 0.06);
      std::vector<double> by(200);
      std::generate(by.begin(), by.end(), [&] { return noise(generator); });
      const Pose2 T_plan_corridor{0.0, 0.0, turn};
      const DistanceField walls = planOf([&](const Eigen::Vector2d& p) {
        Eigen::Vector2d q = T_plan_corridor.inverse() * p;
        if (q.x() < -6.0) return Known::kNothing;
        q.y() += by[static_cast<std::size_t>((q.x() + 10.0) / kCell) % by.size()];
        return corridor(q, wall_end);
      });
      const auto places = continued(walls);
      // Two walls, each from the rim to 10 m beyond where it was drawn, and as many behind the robot.
      double farthest = 0.0;
      int ahead = 0;
      for (const Eigen::Vector2d& place : places) {
        const Eigen::Vector2d p = T_plan_corridor.inverse() * place;
        EXPECT_NEAR(std::abs(p.y()), 1.1, 0.6) << p.transpose();
        EXPECT_GT(std::max(p.x(), -p.x() - 2.0), 3.9) << p.transpose();
        farthest = std::max(farthest, p.x());
        ahead += p.x() > 0.0;
      }
      EXPECT_NEAR(farthest, wall_end + 10.0, 0.4) << turn;
      EXPECT_GT(ahead, 2 * static_cast<int>((wall_end + 6.0) / kCell)) << turn;
    }
  }
}

TEST(WallExtrapolation, AWallThatEndsWithinTheMapEndsThere) {
  const auto end_wall = planOf([](const Eigen::Vector2d& p) {
    if (p.x() > 3.8 && p.x() < 4.0 && std::abs(p.y()) < 1.2) return Known::kSolid;
    return p.x() < -4.0 || p.x() > 4.0 ? Known::kNothing : corridor(p, 3.9);
  });
  const auto hall = planOf([](const Eigen::Vector2d& p) {
    if (p.x() > 2.0 && p.x() < 9.0 && std::abs(p.y()) < 5.0) return Known::kFree;
    return p.x() < -4.0 || p.x() > 2.0 ? Known::kNothing : corridor(p, 2.0);
  });
  for (const DistanceField* walls : {&end_wall, &hall}) {
    for (const Eigen::Vector2d& p : continued(*walls)) EXPECT_LT(p.x(), -3.9) << "behind the robot only";
  }
}

TEST(WallExtrapolation, WhatIsNotStraightIsNotExtrapolated) {
  const auto round = planOf([](const Eigen::Vector2d& p) {
    if (p.y() < 0.0) return Known::kNothing;
    const double radius = (p - Eigen::Vector2d(0.0, -1.0)).norm();
    return radius < 3.0 ? Known::kFree : radius < 3.2 ? Known::kSolid : Known::kNothing;
  });
  EXPECT_TRUE(continued(round).empty());
  const auto stub = planOf([](const Eigen::Vector2d& p) {
    if (p.x() < 0.0 || p.x() > 1.2) return Known::kNothing;
    return corridor(p, 1.2);
  });
  EXPECT_TRUE(continued(stub).empty());
}

}  // namespace
}  // namespace slam::test::wall_extrapolation_test
