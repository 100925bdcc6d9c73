// SPDX-License-Identifier: BSD-3-Clause
#include "graph/optimiser.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace slam {
namespace {

struct Linearised {
  Eigen::Vector3d error;
  Eigen::Matrix3d by_from, by_to;  // derivative by (x, y, theta) of either pose in map
};

/// e = (R_m^T (R_i^T (t_j - t_i) - t_m), theta_j - theta_i - theta_m), m the measured relative pose.
Linearised linearised(const Edge& edge, const Pose2& from, const Pose2& to) {
  const double ci = std::cos(from.theta), si = std::sin(from.theta);
  const double cm = std::cos(edge.T_from_to.theta), sm = std::sin(edge.T_from_to.theta);
  Eigen::Matrix2d Ri_T, dRi_T, Rm_T;
  Ri_T << ci, si, -si, ci;
  dRi_T << -si, ci, -ci, -si;
  Rm_T << cm, sm, -sm, cm;
  const Eigen::Vector2d t(to.x - from.x, to.y - from.y);
  Linearised result;
  result.error.head<2>() = Rm_T * (Ri_T * t - edge.T_from_to.translation());
  result.error.z() = wrapAngle(to.theta - from.theta - edge.T_from_to.theta);
  result.by_from.setZero();
  result.by_from.topLeftCorner<2, 2>() = -Rm_T * Ri_T;
  result.by_from.topRightCorner<2, 1>() = Rm_T * dRi_T * t;
  result.by_from(2, 2) = -1.0;
  result.by_to.setZero();
  result.by_to.topLeftCorner<2, 2>() = Rm_T * Ri_T;
  result.by_to(2, 2) = 1.0;
  return result;
}

/// The nodes that are the fewest edges from `around`, nearest first.
std::vector<int> nodesAround(const PoseGraph& graph, std::span<const int> around, std::size_t count) {
  std::vector<int> found;
  NodeSet is_found;
  const auto add = [&](int node) {
    if (is_found.insert(node)) found.push_back(node);
  };
  for (const int node : around) add(node);
  for (std::size_t i = 0; i < found.size() && found.size() < count; ++i) {
    for (const int id : graph.edgesAt(found[i])) {
      const Edge& edge = graph.edges()[static_cast<std::size_t>(id)];
      if (edge.revoked) continue;
      add(edge.from);
      add(edge.to);
    }
  }
  return found;
}

/// All edges at these nodes, in rising order.
std::vector<int> edgesAt(const PoseGraph& graph, std::span<const int> nodes) {
  std::vector<int> edges;
  for (const int node : nodes) {
    const auto at = graph.edgesAt(node);
    edges.insert(edges.end(), at.begin(), at.end());
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// [m] how far the node that moves farthest goes. @param lever [m] at which a turn counts
double farthestMove(std::span<const Pose2> before, const PoseGraph& graph, std::span<const int> nodes, double lever) {
  double farthest = 0.0;
  for (const int node : nodes) {
    const Pose2 move = between(before[static_cast<std::size_t>(node)], graph.pose(node));
    farthest = std::max({farthest, std::hypot(move.x, move.y), lever * std::abs(move.theta)});
  }
  return farthest;
}

}  // namespace

/// Lays out the matrix's upper triangle, three rows and columns a node, in an order of nodes that keeps the
/// decomposition sparse: fixed nodes have none.
void Optimiser::analyse(const PoseGraph& graph, std::vector<int> solved) {
  std::vector<int> edges = edgesAt(graph, solved);
  if (solved == nodes_ && edges == edges_) return;
  nodes_ = std::move(solved);
  edges_ = std::move(edges);
  const int nodes = static_cast<int>(nodes_.size());
  first_row_.assign(static_cast<std::size_t>(graph.size()), -1);
  for (int i = 0; i < nodes; ++i) first_row_[static_cast<std::size_t>(nodes_[static_cast<std::size_t>(i)])] = i;
  std::vector<Eigen::Triplet<double>> pattern;
  for (int node = 0; node < nodes; ++node) pattern.emplace_back(node, node, 1.0);
  for (const int id : edges_) {
    const Edge& edge = graph.edges()[static_cast<std::size_t>(id)];
    const int i = first_row_[static_cast<std::size_t>(edge.from)], j = first_row_[static_cast<std::size_t>(edge.to)];
    if (std::min(i, j) >= 0) pattern.emplace_back(std::max(i, j), std::min(i, j), 1.0);
  }
  Matrix joined(nodes, nodes);
  joined.setFromTriplets(pattern.begin(), pattern.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(joined.selfadjointView<Eigen::Lower>(), order);
  for (int k = 0; k < nodes; ++k) {
    first_row_[static_cast<std::size_t>(nodes_[static_cast<std::size_t>(order.indices()[k])])] = 3 * k;
  }

  // A node's column blocks hold those of the nodes before it, in their order, and its own.
  pattern.clear();
  const auto rowOf = [&](int node) { return first_row_[static_cast<std::size_t>(node)]; };
  for (int k = 0; k < nodes; ++k) pattern.emplace_back(k, k, 1.0);
  for (const int id : edges_) {
    const Edge& edge = graph.edges()[static_cast<std::size_t>(id)];
    const int i = rowOf(edge.from), j = rowOf(edge.to);
    if (std::min(i, j) >= 0) pattern.emplace_back(std::min(i, j) / 3, std::max(i, j) / 3, 1.0);
  }
  joined.setFromTriplets(pattern.begin(), pattern.end());
  const int *starts = joined.outerIndexPtr(), *rows = joined.innerIndexPtr();
  H_.resize(3 * nodes, 3 * nodes);
  H_.resizeNonZeros(9 * joined.nonZeros() - 3 * nodes);
  int value = 0;
  for (int k = 0; k < nodes; ++k) {
    for (int c = 0; c < 3; ++c) {
      H_.outerIndexPtr()[3 * k + c] = value;
      for (int at = starts[k]; at < starts[k + 1]; ++at) {
        const int size = rows[at] < k ? 3 : c + 1;  // of the diagonal block only the upper triangle
        for (int r = 0; r < size; ++r) H_.innerIndexPtr()[value++] = 3 * rows[at] + r;
      }
    }
  }
  H_.outerIndexPtr()[3 * nodes] = value;
  cholesky_.analyzePattern(H_);

  /// First value of the block (row, column) in each of its columns.
  const auto valuesOf = [&](int row, int column, int(&values)[3]) {
    const int* first = rows + starts[column];
    const int rank = static_cast<int>(std::lower_bound(first, rows + starts[column + 1], row) - first);
    for (int c = 0; c < 3; ++c) values[c] = H_.outerIndexPtr()[3 * column + c] + 3 * rank;
  };
  blocks_.clear();
  for (const int id : edges_) {
    const Edge& edge = graph.edges()[static_cast<std::size_t>(id)];
    Block block{{-1, -1, -1}, {-1, -1, -1}, {-1, -1, -1}, false};
    const int i = rowOf(edge.from), j = rowOf(edge.to);
    block.transposed = i > j;
    if (i >= 0) valuesOf(i / 3, i / 3, block.diagonal_from);
    if (j >= 0) valuesOf(j / 3, j / 3, block.diagonal_to);
    if (i >= 0 && j >= 0) valuesOf(std::min(i, j) / 3, std::max(i, j) / 3, block.off_diagonal);
    blocks_.push_back(block);
  }
  diagonal_.resize(static_cast<std::size_t>(3 * nodes));
  for (int k = 0; k < 3 * nodes; ++k) diagonal_[static_cast<std::size_t>(k)] = H_.outerIndexPtr()[k + 1] - 1;
}

double Optimiser::robustCost(const Edge& edge, double chi_square) const {
  if (edge.kind == EdgeKind::kMotion) return 0.5 * chi_square;
  const double s2 = config_.kernel_scale * config_.kernel_scale;
  return 0.5 * s2 * std::log1p(chi_square / s2);
}

double Optimiser::cost(const PoseGraph& graph, std::span<const Pose2> poses) const {
  double sum = 0.0;
  for (const int id : edges_) {
    const Edge& edge = graph.edges()[static_cast<std::size_t>(id)];
    if (edge.revoked) continue;
    sum += robustCost(
        edge, chiSquare(edge, poses[static_cast<std::size_t>(edge.from)], poses[static_cast<std::size_t>(edge.to)]));
  }
  return sum;
}

double Optimiser::linearise(const PoseGraph& graph, std::span<const Pose2> poses) {
  std::fill(H_.valuePtr(), H_.valuePtr() + H_.nonZeros(), 0.0);
  g_ = Eigen::VectorXd::Zero(H_.rows());
  double sum = 0.0;
  const double s2 = config_.kernel_scale * config_.kernel_scale;
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    const Edge& edge = graph.edges()[static_cast<std::size_t>(edges_[e])];
    if (edge.revoked) continue;
    const Linearised l =
        linearised(edge, poses[static_cast<std::size_t>(edge.from)], poses[static_cast<std::size_t>(edge.to)]);
    const double chi_square = l.error.dot(edge.information * l.error);
    sum += robustCost(edge, chi_square);
    const double weight = edge.kind == EdgeKind::kMotion ? 1.0 : 1.0 / (1.0 + chi_square / s2);
    const Eigen::Matrix3d W = weight * edge.information;
    const Eigen::Matrix3d from_W = l.by_from.transpose() * W, to_W = l.by_to.transpose() * W;
    const Block& block = blocks_[e];
    const auto addDiagonal = [&](const int* columns, const Eigen::Matrix3d& M) {
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r <= c; ++r) H_.valuePtr()[columns[c] + r] += M(r, c);
      }
    };
    if (block.diagonal_from[0] >= 0) {
      addDiagonal(block.diagonal_from, from_W * l.by_from);
      g_.segment<3>(first_row_[static_cast<std::size_t>(edge.from)]) += from_W * l.error;
    }
    if (block.diagonal_to[0] >= 0) {
      addDiagonal(block.diagonal_to, to_W * l.by_to);
      g_.segment<3>(first_row_[static_cast<std::size_t>(edge.to)]) += to_W * l.error;
    }
    if (block.off_diagonal[0] >= 0) {
      const Eigen::Matrix3d M =
          block.transposed ? Eigen::Matrix3d(to_W * l.by_from) : Eigen::Matrix3d(from_W * l.by_to);
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) H_.valuePtr()[block.off_diagonal[c] + r] += M(r, c);
      }
    }
  }
  for (const int k : diagonal_) {
    if (H_.valuePtr()[k] == 0.0) H_.valuePtr()[k] = 1.0;  // no edge speaks of it: it stays, as g is zero there
  }
  return sum;
}

OptimiserReport Optimiser::optimise(PoseGraph& graph) {
  std::vector<int> nodes(static_cast<std::size_t>(std::max(0, graph.size() - 1)));
  std::iota(nodes.begin(), nodes.end(), 1);
  OptimiserReport report = solve(graph, std::move(nodes));
  report.whole = true;
  solved_ = graph.size();
  return report;
}

OptimiserReport Optimiser::optimise(PoseGraph& graph, std::span<const int> around) {
  if (graph.size() > (1.0 + config_.growth) * solved_) return optimise(graph);
  for (auto size = static_cast<std::size_t>(config_.region);; size *= 2) {
    if (2 * size > static_cast<std::size_t>(graph.size())) return optimise(graph);
    const std::vector<int> near = nodesAround(graph, around, size);
    if (2 * near.size() > static_cast<std::size_t>(graph.size())) return optimise(graph);
    const std::vector<Pose2> before(graph.poses().begin(), graph.poses().end());
    std::vector<int> nodes = near;
    std::sort(nodes.begin(), nodes.end());
    const OptimiserReport report = solve(graph, std::move(nodes));
    const bool is_all = near.size() < size;  // no edge leads on
    const double moved = farthestMove(before, graph, std::span(near).subspan(near.size() / 2), config_.region_lever);
    if (is_all || moved < config_.region_still) return report;
  }
}

/// Solves for these nodes, in rising order; all others stay.
OptimiserReport Optimiser::solve(PoseGraph& graph, std::vector<int> nodes) {
  OptimiserReport report;
  if (nodes.empty()) return report;
  analyse(graph, std::move(nodes));
  std::vector<Pose2> poses(graph.poses().begin(), graph.poses().end()), tried = poses;
  double damping = config_.first_damping;
  double now = linearise(graph, poses);
  report.cost_before = report.cost_after = now;
  while (report.iterations < config_.max_iterations && damping < config_.max_damping) {
    ++report.iterations;
    // Levenberg: a share of the diagonal is added to it.
    for (const int k : diagonal_) H_.valuePtr()[k] *= 1.0 + damping;
    cholesky_.factorize(H_);
    for (const int k : diagonal_) H_.valuePtr()[k] /= 1.0 + damping;
    if (cholesky_.info() != Eigen::Success) {
      damping = std::max(1e-6, 10.0 * damping);
      continue;
    }
    const Eigen::VectorXd step = cholesky_.solve(-g_);
    if (!step.allFinite()) return report;
    for (const int n : nodes_) {
      const auto d = step.segment<3>(first_row_[static_cast<std::size_t>(n)]);
      const Pose2& pose = poses[static_cast<std::size_t>(n)];
      tried[static_cast<std::size_t>(n)] = {pose.x + d.x(), pose.y + d.y(), wrapAngle(pose.theta + d.z())};
    }
    const double after = cost(graph, tried);
    const bool small = step.lpNorm<Eigen::Infinity>() < config_.step_tolerance;
    if (!(after <= now)) {
      if (small && std::isfinite(after)) {  // no better but for rounding
        report.converged = true;
        break;
      }
      damping = std::max(1e-6, 10.0 * damping);
      continue;
    }
    poses = tried;
    const bool settled = small || now - after <= config_.relative_tolerance * now;
    damping *= 0.1;
    report.cost_after = now = after;
    if (settled) {
      report.converged = true;
      break;
    }
    now = linearise(graph, poses);
  }
  for (const int n : nodes_) graph.setPose(n, poses[static_cast<std::size_t>(n)]);
  return report;
}

}  // namespace slam
