// SPDX-License-Identifier: BSD-3-Clause
#include "posegraph/pose_graph.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <queue>

namespace slam {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();
constexpr double kBlindVariance = 1e2;  // [m^2, rad^2] of a direction that an edge says nothing about

EdgeVariances variancesOf(const Edge& edge) {
  const Eigen::Matrix3d regular = edge.information + Eigen::Matrix3d::Identity() / kBlindVariance;
  const Eigen::Matrix3d covariance = regular.inverse();
  // Along the worst direction: the next edge's axes may lie along it.
  const double mean = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double spread = std::hypot(0.5 * (covariance(0, 0) - covariance(1, 1)), covariance(0, 1));
  return {mean + spread, covariance(2, 2), std::hypot(edge.T_from_to.x, edge.T_from_to.y)};
}

}  // namespace

int PoseGraph::addNode(const Pose2& T_map_node) {
  poses_.push_back(T_map_node);
  edges_of_.emplace_back();
  best_.push_back(kUnknown);
  return size() - 1;
}

int PoseGraph::addEdge(const Edge& edge) {
  const int id = static_cast<int>(edges_.size());
  edges_.push_back(edge);
  variances_.push_back(variancesOf(edge));
  edges_of_[static_cast<std::size_t>(edge.from)].push_back(id);
  edges_of_[static_cast<std::size_t>(edge.to)].push_back(id);
  return id;
}

void PoseGraph::truncate(int count) {
  const std::vector<Edge> edges = std::exchange(edges_, {});
  const auto size = static_cast<std::size_t>(count);
  poses_.resize(size);
  best_.resize(size);
  variances_.clear();
  edges_of_.assign(size, {});
  for (const Edge& edge : edges) {
    if (edge.from < count && edge.to < count) addEdge(edge);
  }
}

std::vector<PoseGraph::Reached> PoseGraph::reach(int anchor, double max_position_variance) const {
  // Dijkstra's algorithm on the position's variance. A heading error swings all of the chain that follows, so its
  // covariance with the position is carried along; that bounds curved chains, too.
  struct Step {
    double position, cross, heading;  // [m^2, m rad, rad^2]
    int node;
    bool operator>(const Step& other) const { return position > other.position; }
  };
  std::priority_queue<Step, std::vector<Step>, std::greater<>> queue;
  std::vector<Reached> reached;
  std::vector<int> touched{anchor};
  best_[static_cast<std::size_t>(anchor)] = 0.0;
  queue.push({0.0, 0.0, 0.0, anchor});
  while (!queue.empty()) {
    const Step step = queue.top();
    queue.pop();
    if (step.position > best_[static_cast<std::size_t>(step.node)]) continue;
    reached.push_back({step.node, step.position, step.heading});
    for (const int id : edges_of_[static_cast<std::size_t>(step.node)]) {
      const Edge& edge = edges_[static_cast<std::size_t>(id)];
      if (edge.revoked) continue;
      const int next = edge.from == step.node ? edge.to : edge.from;
      const EdgeVariances& variances = variances_[static_cast<std::size_t>(id)];
      const double length = variances.length;
      // Against its direction an edge's own heading error swings it, too; along it that swings only what follows.
      const double swinging = step.heading + (edge.to == step.node ? variances.heading : 0.0);
      const double position = step.position + (2.0 * step.cross + swinging * length) * length + variances.position;
      if (position > max_position_variance || position >= best_[static_cast<std::size_t>(next)]) continue;
      best_[static_cast<std::size_t>(next)] = position;
      touched.push_back(next);
      queue.push({position, step.cross + swinging * length, step.heading + variances.heading, next});
    }
  }
  for (const int node : touched) best_[static_cast<std::size_t>(node)] = kUnknown;
  return reached;
}

double chiSquare(const Edge& edge, const Pose2& T_map_from, const Pose2& T_map_to) {
  const Eigen::Vector3d error = between(edge.T_from_to, between(T_map_from, T_map_to)).vector();
  return error.dot(edge.information * error);
}

}  // namespace slam
