// SPDX-License-Identifier: BSD-3-Clause
#include "slam/loop_closer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "graph/align_map.hpp"

namespace slam {
namespace {

/// @return [m] standard deviation of each node's position relative to `first`, as it was without these closures
std::vector<double> sigmaWithout(PoseGraph& graph, std::span<const int> closures, int first) {
  std::vector<int> taken_out;
  for (const int edge : closures) {
    if (graph.edges()[static_cast<std::size_t>(edge)].revoked) continue;
    graph.revoke(edge);
    taken_out.push_back(edge);
  }
  constexpr double unknown = std::numeric_limits<double>::infinity();
  std::vector<double> sigma(static_cast<std::size_t>(graph.size()), unknown);
  for (const PoseGraph::Reached& reached : graph.reach(first, unknown)) {
    sigma[static_cast<std::size_t>(reached.node)] = std::sqrt(reached.position_variance);
  }
  for (const int edge : taken_out) graph.restore(edge);
  return sigma;
}

/// Lays the optimised map where it moves least, by what was known of it before these closures.
void align(KeyframeMap& map, std::span<const Pose2> before, std::span<const int> closures) {
  PoseGraph& graph = map.keyframes.graph();
  const std::vector<int> ids = map.idsInMap();
  if (ids.empty()) return;
  const std::vector<double> sigma_of = sigmaWithout(graph, closures, ids.front());
  std::vector<Pose2> T_map_node, T_new_node;
  std::vector<double> sigma;
  for (const int id : ids) {
    T_map_node.push_back(before[static_cast<std::size_t>(id)]);
    T_new_node.push_back(graph.pose(id));
    sigma.push_back(sigma_of[static_cast<std::size_t>(id)]);
  }
  const Pose2 T_map_new = alignToPreviousMap(T_map_node, T_new_node, sigma);
  for (int id = 0; id < graph.size(); ++id) graph.setPose(id, T_map_new * graph.pose(id));
}

}  // namespace

LoopCloser::LoopCloser(const BackEndConfig& config)
    : max_chi_square_(config.closure.max_chi_square),
      search_(config.closure, config.relocalisation.places, config.reference, config.match),
      optimiser_(config.optimiser) {}

void LoopCloser::close(KeyframeMap& map) {
  const auto closures = search_.search(map.keyframes, map.in_map);
  if (closures.empty()) return;
  PoseGraph& graph = map.keyframes.graph();
  const std::vector<Pose2> before(graph.poses().begin(), graph.poses().end());
  std::vector<int> added, ends;
  for (const Edge& edge : closures) {
    added.push_back(graph.addEdge(edge));
    ends.insert(ends.end(), {edge.from, edge.to});
  }
  bool all = optimise(graph, ends);
  all |= revokeContradicted(graph);
  if (all) align(map, before, added);  // else most of it has stayed
  closed_ = static_cast<int>(std::count_if(graph.edges().begin(), graph.edges().end(), [](const Edge& edge) {
    return edge.kind == EdgeKind::kLoopClosure && !edge.revoked;
  }));
  ++map.generation;
}

bool LoopCloser::optimise(PoseGraph& graph, std::span<const int> around) {
  ++optimisations_;
  return optimiser_.optimise(graph, around).whole;
}

bool LoopCloser::revokeContradicted(PoseGraph& graph) {
  bool all = false;
  // One at a time, the worst first: taking it back may satisfy the others.
  for (;;) {
    int worst = -1;
    double largest = max_chi_square_;
    for (std::size_t e = 0; e < graph.edges().size(); ++e) {
      const Edge& edge = graph.edges()[e];
      if (edge.kind != EdgeKind::kLoopClosure || edge.revoked) continue;
      const double chi_square = chiSquare(edge, graph.pose(edge.from), graph.pose(edge.to));
      if (chi_square <= largest) continue;
      largest = chi_square;
      worst = static_cast<int>(e);
    }
    if (worst < 0) return all;
    graph.revoke(worst);
    ++revoked_;
    const Edge& edge = graph.edges()[static_cast<std::size_t>(worst)];
    all |= optimise(graph, std::array{edge.from, edge.to});
  }
}

void LoopCloser::addTo(BackEndCounters& counters) const {
  counters.loop_closures = closed_;
  counters.revoked = revoked_;
  counters.optimisations = optimisations_;
  counters.search = search_.counters();
}

}  // namespace slam
