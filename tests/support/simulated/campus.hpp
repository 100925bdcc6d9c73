// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "graph/pose_graph.hpp"

namespace slam::test {

/// A robot that roams the streets of a campus, 20 m apart, with a keyframe every 0.4 m, and recognises places.
struct Campus {
  PoseGraph graph;  ///< poses as dead-reckoned: the closures are not yet worked in
  std::vector<Pose2> truth;
  std::vector<Edge> closures;  ///< in the order of their discovery; not in the graph
};

inline Edge measuredEdge(const std::vector<Pose2>& truth, int from, int to, const Eigen::Vector3d& sigma, EdgeKind kind,
                         std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Pose2 noise{sigma.x() * normal(random), sigma.y() * normal(random), sigma.z() * normal(random)};
  return {from, to, between(truth[static_cast<std::size_t>(from)], truth[static_cast<std::size_t>(to)]) * noise,
          sigma.cwiseAbs2().cwiseInverse().asDiagonal(), kind};
}

inline Campus makeCampus(int keyframes, unsigned seed) {
  constexpr double kStep = 0.4;
  constexpr int kStepsPerBlock = 50, kBlocks = 8;
  const Eigen::Vector3d motion(0.007, 0.007, 0.0015), closure(0.02, 0.02, 0.005);
  std::mt19937 random(seed);
  Campus campus;
  Pose2 pose;
  campus.truth.push_back(pose);
  campus.graph.addNode(pose);
  while (static_cast<int>(campus.truth.size()) < keyframes) {
    if ((campus.truth.size() - 1) % kStepsPerBlock == 0) {  // a crossing: go on or turn, but stay on the campus
      std::uniform_int_distribution<int> choice(-1, 1);
      for (;;) {
        const double theta = wrapAngle(pose.theta + choice(random) * std::numbers::pi / 2);
        const double x = pose.x + 20.0 * std::cos(theta), y = pose.y + 20.0 * std::sin(theta);
        if (std::abs(x) < 20.0 * kBlocks / 2 + 1 && std::abs(y) < 20.0 * kBlocks / 2 + 1) {
          pose.theta = theta;
          break;
        }
        if (std::abs(x) + std::abs(y) > 1e4) break;
        pose.theta = wrapAngle(pose.theta + std::numbers::pi / 2);
      }
    }
    pose = pose * Pose2{kStep, 0.0, 0.0};
    campus.truth.push_back(pose);
    const int id = static_cast<int>(campus.truth.size()) - 1;
    const Edge edge = measuredEdge(campus.truth, id - 1, id, motion, EdgeKind::kMotion, random);
    campus.graph.addNode(campus.graph.pose(id - 1) * edge.T_from_to);
    campus.graph.addEdge(edge);
    if (id % 10 != 0) continue;
    for (int other = 0; other < id - 100; ++other) {
      const Pose2& there = campus.truth[static_cast<std::size_t>(other)];
      if (std::hypot(there.x - pose.x, there.y - pose.y) > 0.5) continue;
      campus.closures.push_back(measuredEdge(campus.truth, other, id, closure, EdgeKind::kLoopClosure, random));
      break;
    }
  }
  return campus;
}

}  // namespace slam::test
