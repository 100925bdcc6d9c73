// SPDX-License-Identifier: BSD-3-Clause
#include "graph/align_map.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace slam {
namespace {

struct Node {
  Eigen::Vector2d p_map, p_new;  // [m]
  double known;                  // [m^-1/2] by which its motion counts
  double turn;                   // [rad] from new to map
  double cos_turn, sin_turn;
};

/// The transform with the least weighted sum of squared motions, in closed form: each node counts as points `lever`
/// around it.
template <typename Weight>
Pose2 leastSquares(std::span<const Node> nodes, double lever, const Weight& weightOf) {
  double sum = 0.0, along = 0.0, across = 0.0;
  Eigen::Vector2d sum_map = Eigen::Vector2d::Zero(), sum_new = Eigen::Vector2d::Zero();
  for (const Node& node : nodes) {
    const double weight = weightOf(node);
    const Eigen::Vector2d &p = node.p_new, &q = node.p_map;
    sum += weight;
    sum_map += weight * q;
    sum_new += weight * p;
    along += weight * (p.dot(q) + lever * lever * node.cos_turn);
    across += weight * (p.x() * q.y() - p.y() * q.x() + lever * lever * node.sin_turn);
  }
  along -= sum_new.dot(sum_map) / sum;  // both about the means
  across -= (sum_new.x() * sum_map.y() - sum_new.y() * sum_map.x()) / sum;
  const double theta = std::atan2(across, along);
  const Eigen::Vector2d translation = (sum_map - Eigen::Rotation2Dd(theta) * sum_new) / sum;
  return {translation.x(), translation.y(), theta};
}

}  // namespace

Pose2 alignToPreviousMap(std::span<const Pose2> T_map_node, std::span<const Pose2> T_new_node,
                         std::span<const double> sigma, const AlignMapConfig& config) {
  if (T_map_node.empty() || T_map_node.size() != T_new_node.size()) return {};
  std::vector<Node> nodes;
  nodes.reserve(T_map_node.size());
  for (std::size_t i = 0; i < T_map_node.size(); ++i) {
    const double turn = wrapAngle(T_map_node[i].theta - T_new_node[i].theta);
    const double s = sigma.size() == T_map_node.size() ? sigma[i] : 0.0;
    const double known = 1.0 / std::sqrt(std::hypot(config.least_move, s));
    nodes.push_back(
        {T_map_node[i].translation(), T_new_node[i].translation(), known, turn, std::cos(turn), std::sin(turn)});
  }
  Pose2 T_map_new = leastSquares(nodes, config.lever, [](const Node& node) { return node.known; });
  for (int i = 0; i < config.max_iterations; ++i) {
    const Pose2 last = T_map_new;
    const Eigen::Matrix2d rotation = Eigen::Rotation2Dd(last.theta).toRotationMatrix();
    T_map_new = leastSquares(nodes, config.lever, [&](const Node& node) {
      const double moved = (rotation * node.p_new + last.translation() - node.p_map).norm();
      const double turned = config.lever * wrapAngle(node.turn - last.theta);
      return node.known / std::max(config.least_move, std::hypot(moved, turned));
    });
    if (between(last, T_map_new).vector().lpNorm<Eigen::Infinity>() < config.converged) break;
  }
  return T_map_new;
}

}  // namespace slam
