// SPDX-License-Identifier: BSD-3-Clause
#include "graph/align_map.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace slam::align_map_test {
namespace {

std::vector<Pose2> randomNodes(int count, std::mt19937& random) {
  std::uniform_real_distribution<double> place(-30.0, 30.0), heading(-3.0, 3.0);
  std::vector<Pose2> nodes;
  for (int i = 0; i < count; ++i) nodes.push_back({place(random), place(random), heading(random)});
  return nodes;
}

std::vector<Pose2> moved(const Pose2& T, std::vector<Pose2> nodes) {
  for (Pose2& node : nodes) node = T * node;
  return nodes;
}

double distance(const Pose2& a, const Pose2& b) { return (a.translation() - b.translation()).norm(); }

void expectNear(const Pose2& pose, const Pose2& expected, double tolerance) {
  EXPECT_LT(distance(pose, expected), tolerance);
  EXPECT_LT(std::abs(wrapAngle(pose.theta - expected.theta)), tolerance);
}

TEST(AlignMap, APartThatKeepsItsShapeKeepsItsPlaceWhileItIsTheLarger) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.002);
  for (int run = 0; run < 20; ++run) {
    const std::vector<Pose2> before = randomNodes(100, random);
    std::vector<Pose2> after = before;
    for (int i = 0; i < 100; ++i) {
      Pose2& node = after[static_cast<std::size_t>(i)];
      node.x += noise(random);
      node.y += noise(random);
      if (i >= 70) node = Pose2{0.8, -0.5, 0.05} * node;  // a branch that a loop has put in its place
    }
    const Pose2 T_new_frame{4.0, -7.0, 2.0};
    expectNear(alignToPreviousMap(before, moved(T_new_frame, after)) * T_new_frame, {}, 0.03);
  }
}

TEST(AlignMap, ALoopsDriftMovesItsNodesByHalfAsMuchAsWithTheFirstHeld) {
  std::vector<Pose2> before, after;
  for (int i = 0; i <= 200; ++i) {
    const double turn = 2.0 * 3.14159265 * i / 200.0;
    before.push_back({10.0 * std::sin(turn), 10.0 - 10.0 * std::cos(turn), turn});
    after.push_back({before.back().x + 0.001 * i, before.back().y, turn});  // 0.2 m of drift, node 0 held
  }
  const Pose2 T_map_new = alignToPreviousMap(before, after);
  double held = 0.0, first = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    held += distance(before[i], T_map_new * after[i]);
    first += distance(before[i], after[i]);
  }
  EXPECT_LT(held, 0.55 * first);
}

TEST(AlignMap, WhatIsKnownToACentimetreStaysThoughALargerPartHasDrifted) {
  std::mt19937 random(6);
  for (int run = 0; run < 20; ++run) {
    const std::vector<Pose2> before = randomNodes(100, random);
    std::vector<Pose2> after = before;
    std::vector<double> sigma(100, 0.01);
    for (std::size_t i = 40; i < 100; ++i) {  // a loop has brought them back by a tenth of a metre
      after[i] = Pose2{0.1, -0.05, 0.005} * after[i];
      sigma[i] = 0.3;
    }
    const Pose2 T_new_frame{4.0, -7.0, 2.0};
    expectNear(alignToPreviousMap(before, moved(T_new_frame, after), sigma) * T_new_frame, {}, 0.02);
    EXPECT_GT(distance(alignToPreviousMap(before, moved(T_new_frame, after)) * T_new_frame, {}), 0.05)
        << "all alike: the larger part stays";
  }
}

TEST(AlignMap, UndoesAMotionOfTheWholeMap) {
  std::mt19937 random(2);
  for (int run = 0; run < 50; ++run) {
    const std::vector<Pose2> before = randomNodes(1 + run, random);
    const Pose2 T_new_map = randomNodes(1, random).front();
    expectNear(alignToPreviousMap(before, moved(T_new_map, before)), T_new_map.inverse(), 1e-9);
  }
}

TEST(AlignMap, NodesOfOnePlaceKeepTheirHeading) {
  // Their positions alone say nothing of it.
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.002);
  std::vector<Pose2> before, after;
  for (int i = 0; i < 40; ++i) {
    before.push_back({noise(random), noise(random), 0.1 * i});
    after.push_back({noise(random), noise(random), 0.1 * i + noise(random)});
  }
  expectNear(alignToPreviousMap(before, after), {}, 0.003);
}

TEST(AlignMap, WithoutNodesOrWithOthersItHoldsNothing) {
  const std::vector<Pose2> one{{1.0, 2.0, 3.0}}, two{{1.0, 2.0, 3.0}, {2.0, 2.0, 3.0}};
  EXPECT_EQ(alignToPreviousMap({}, {}), Pose2{});
  EXPECT_EQ(alignToPreviousMap(one, two), Pose2{});
}

/// Sum over the nodes of a function of their squared motion, a turn taken at the lever.
template <typename Function>
double motion(const std::vector<Pose2>& before, const std::vector<Pose2>& after, const Eigen::Vector3d& T, double lever,
              Function&& of) {
  double sum = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Pose2 there = Pose2{T.x(), T.y(), T.z()} * after[i];
    const double turned = 2.0 * lever * lever * (1.0 - std::cos(before[i].theta - there.theta));
    sum += of((there.translation() - before[i].translation()).squaredNorm() + turned);
  }
  return sum;
}

std::vector<Pose2> disturbed(std::vector<Pose2> nodes, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (Pose2& node : nodes) {
    node = Pose2{3.0, -2.0, 1.0} * node * Pose2{unit(random), unit(random), 0.2 * unit(random)};
  }
  return nodes;
}

TEST(AlignMap, TheFirstGuessIsTheLeastSumOfSquares) {
  std::mt19937 random(4);
  for (const double lever : {0.5, 5.0, 30.0}) {
    const std::vector<Pose2> before = randomNodes(15, random), after = disturbed(before, random);
    const Eigen::Vector3d T = alignToPreviousMap(before, after, {}, {.lever = lever, .max_iterations = 0}).vector();
    const auto cost = [&](const Eigen::Vector3d& v) {
      return motion(before, after, v, lever, [](double m) { return m; });
    };
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = 1e-3 * Eigen::Vector3d::Unit(i);
      const double ahead = cost(T + d) - cost(T), behind = cost(T - d) - cost(T);
      EXPECT_GT(ahead, 0.0);
      EXPECT_NEAR(ahead, behind, 1e-2 * ahead) << "the middle of the valley, lever " << lever << ", " << i;
    }
  }
}

TEST(AlignMap, ThenTheLeastSumOfMotions) {
  std::mt19937 random(5);
  for (const double lever : {0.5, 5.0, 30.0}) {
    const std::vector<Pose2> before = randomNodes(15, random), after = disturbed(before, random);
    const AlignMapConfig config{.lever = lever, .max_iterations = 300};
    const Eigen::Vector3d T = alignToPreviousMap(before, after, {}, config).vector();
    const auto cost = [&](const Eigen::Vector3d& v) {
      return motion(before, after, v, lever, [](double m) { return std::sqrt(m); });
    };
    for (int i = 0; i < 3; ++i) {
      for (const double step : {-0.02, 0.02}) {
        const double size = i == 2 ? step / lever : step;
        EXPECT_GE(cost(T + size * Eigen::Vector3d::Unit(i)), cost(T)) << lever << " " << i;
      }
    }
  }
}

TEST(AlignMap, WhatHardlyMovesAtAllWeighsNoMore) {
  // One node that has not moved holds the map as long as it does not count as many.
  const std::vector<Pose2> before{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, after{{0, 0, 0}, {1.1, 0, 0}, {2.1, 0, 0}};
  EXPECT_NEAR(alignToPreviousMap(before, after, {}, {.least_move = 10.0}).x, -0.2 / 3, 1e-3)
      << "all the same: the mean";
  EXPECT_NEAR(alignToPreviousMap(before, after, {}, {.least_move = 1e-3, .max_iterations = 100}).x, -0.1, 2e-3)
      << "the larger part";
}

}  // namespace
}  // namespace slam::align_map_test
