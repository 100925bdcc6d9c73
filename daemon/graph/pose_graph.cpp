// SPDX-License-Identifier: BSD-3-Clause
#include "graph/pose_graph.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace slam {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();
constexpr double kBlindVariance = 1e2;  // [m^2, rad^2] of a direction that an edge says nothing about

}  // namespace

PoseGraph::Link PoseGraph::linkOf(const Edge& edge) {
  const Eigen::Matrix3d regular = edge.information + Eigen::Matrix3d::Identity() / kBlindVariance;
  const Eigen::Matrix3d covariance = regular.inverse();
  // Along the worst direction: the next edge's axes may lie along it.
  const double mean = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double spread = std::hypot(0.5 * (covariance(0, 0) - covariance(1, 1)), covariance(0, 1));
  return {.from = edge.from,
          .to = edge.to,
          .revoked = edge.revoked,
          .position = mean + spread,
          .heading = covariance(2, 2),
          .length = std::hypot(edge.T_from_to.x, edge.T_from_to.y)};
}

int PoseGraph::addNode(const Pose2& T_map_node) {
  poses_.push_back(T_map_node);
  edges_of_.emplace_back();
  best_.push_back(kUnknown);
  index_.add(T_map_node.translation());
  return size() - 1;
}

void PoseGraph::setPose(int node, const Pose2& T_map_node) {
  poses_[static_cast<std::size_t>(node)] = T_map_node;
  index_.move(node, T_map_node.translation());
}

std::vector<int> PoseGraph::near(const Eigen::Vector2d& p_map, double radius) const {
  std::vector<int> nodes = index_.candidates(p_map, radius);
  std::erase_if(nodes, [&](int node) { return !((pose(node).translation() - p_map).squaredNorm() < radius * radius); });
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

int PoseGraph::addEdge(const Edge& edge) {
  forgetSearch();
  const int id = static_cast<int>(edges_.size());
  edges_.push_back(edge);
  links_.push_back(linkOf(edge));
  edges_of_[static_cast<std::size_t>(edge.from)].push_back(id);
  edges_of_[static_cast<std::size_t>(edge.to)].push_back(id);
  return id;
}

void PoseGraph::truncate(int count) {
  forgetSearch();
  const std::vector<Edge> edges = std::exchange(edges_, {});
  const auto size = static_cast<std::size_t>(count);
  poses_.resize(size);
  best_.resize(size);
  index_.truncate(count);
  links_.clear();
  edges_of_.assign(size, {});
  for (const Edge& edge : edges) {
    if (edge.from < count && edge.to < count) addEdge(edge);
  }
}

std::vector<PoseGraph::Reached> PoseGraph::reach(int anchor, double max_position_variance) const {
  return reachUntil(anchor, max_position_variance, [](int) { return false; });
}

std::vector<PoseGraph::Reached> PoseGraph::reach(int anchor, double max_position_variance,
                                                 std::span<const int> wanted) const {
  wanted_.clear();
  std::size_t left = 0;
  for (const int node : wanted) left += wanted_.insert(node) ? 1 : 0;
  return reachUntil(anchor, max_position_variance, [&](int node) { return wanted_.contains(node) && --left == 0; });
}

template <typename IsEnough>
std::vector<PoseGraph::Reached> PoseGraph::reachUntil(int anchor, double max_position_variance,
                                                      IsEnough&& isEnough) const {
  if (search_.anchor != anchor) {
    forgetSearch();
    search_.anchor = anchor;
    best_[static_cast<std::size_t>(anchor)] = 0.0;
    search_.touched.push_back(anchor);
    search_.queue.push_back({0.0, 0.0, 0.0, anchor});
  }
  std::size_t count = 0;
  for (bool enough = false; !enough; ++count) {
    if (count == search_.done.size() && !reachNext(max_position_variance)) break;
    const Reached& reached = search_.done[count];
    if (reached.position_variance > max_position_variance) break;
    enough = isEnough(reached.node);
  }
  return {search_.done.begin(), search_.done.begin() + static_cast<std::ptrdiff_t>(count)};
}

/// Goes on to the next node. @return false: none is left within the bound
bool PoseGraph::reachNext(double max_position_variance) const {
  // Dijkstra's algorithm on the position's variance. A heading error swings all of the chain that follows, so its
  // covariance with the position is carried along; that bounds curved chains, too.
  auto& queue = search_.queue;
  while (!queue.empty() && queue.front().position <= max_position_variance) {
    const Search::Step step = queue.front();
    std::pop_heap(queue.begin(), queue.end(), std::greater<>());
    queue.pop_back();
    if (step.position > best_[static_cast<std::size_t>(step.node)]) continue;
    search_.done.push_back({step.node, step.position, step.heading});
    for (const int id : edges_of_[static_cast<std::size_t>(step.node)]) {
      const Link& link = links_[static_cast<std::size_t>(id)];
      if (link.revoked) continue;
      const int next = link.from == step.node ? link.to : link.from;
      // Against its direction an edge's own heading error swings it, too; along it that swings only what follows.
      const double swinging = step.heading + (link.to == step.node ? link.heading : 0.0);
      const double position = step.position + (2.0 * step.cross + swinging * link.length) * link.length + link.position;
      if (position >= best_[static_cast<std::size_t>(next)]) continue;
      best_[static_cast<std::size_t>(next)] = position;
      search_.touched.push_back(next);
      queue.push_back({position, step.cross + swinging * link.length, step.heading + link.heading, next});
      std::push_heap(queue.begin(), queue.end(), std::greater<>());
    }
    return true;
  }
  return false;
}

void PoseGraph::forgetSearch() const {
  for (const int node : search_.touched) best_[static_cast<std::size_t>(node)] = kUnknown;
  search_.anchor = -1;
  search_.queue.clear();
  search_.done.clear();
  search_.touched.clear();
}

double chiSquare(const Edge& edge, const Pose2& T_map_from, const Pose2& T_map_to) {
  const double c = std::cos(T_map_from.theta), s = std::sin(T_map_from.theta);
  const double cm = std::cos(edge.T_from_to.theta), sm = std::sin(edge.T_from_to.theta);
  const double dx = T_map_to.x - T_map_from.x, dy = T_map_to.y - T_map_from.y;
  const double x = c * dx + s * dy - edge.T_from_to.x, y = c * dy - s * dx - edge.T_from_to.y;
  const Eigen::Vector3d error(cm * x + sm * y, cm * y - sm * x,
                              wrapAngle(T_map_to.theta - T_map_from.theta - edge.T_from_to.theta));
  return error.dot(edge.information * error);
}

}  // namespace slam
