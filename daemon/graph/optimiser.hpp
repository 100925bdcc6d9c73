// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "graph/pose_graph.hpp"

namespace slam {

struct OptimiserConfig {
  int max_iterations = 20;
  double relative_tolerance = 1e-5;  ///< [1] a step that lowers the cost by a smaller share has converged
  double step_tolerance = 1e-5;      ///< [m, rad] largest change of a node in a step that has converged
  double kernel_scale = 3.0;         ///< [1] Mahalanobis distance at which a loop closure has lost half its weight
  double first_damping = 1e-8;       ///< [1] of the diagonal
  double max_damping = 1e6;          ///< [1] of the diagonal: then no step lowers the cost
  int region = 2048;                 ///< nodes around a disturbance that are solved for first
  double region_still = 0.002;       ///< [m] where the farther half of them moves by less, that is enough ...
  double region_lever = 2.0;         ///< [m] ... at so much from each node
  double growth = 0.1;               ///< [1] by which the graph may grow until all nodes are solved for again
};

struct OptimiserReport {
  bool converged = false;  ///< false: the poses are as good as the iterations allowed, or as before if it failed
  bool whole = false;      ///< all nodes were solved for
  int iterations = 0;
  double cost_before = 0.0, cost_after = 0.0;  ///< half the robust sum of squares [1] of what was solved for
};

/// Sparse nonlinear least squares over the poses of a graph:
///
///     min sum_motion |e|^2 + sum_closures s^2 log(1 + |e|^2/s^2),    e = T_from_to^-1 * (T_from^-1 * T_to)
///
/// by Gauss-Newton with Levenberg's damping; node 0 stays. Each step factorises the normal equations by a sparse
/// Cholesky decomposition whose ordering and symbolic part are kept while the graph keeps its edges.
/// [Grisetti 2010] G. Grisetti et al., "A tutorial on graph-based SLAM", IEEE ITS Magazine 2(4).
/// Cauchy's kernel gives wrong closures little weight [Agarwal 2013, Lee 2013].
///
/// A new edge in a graph that is at its optimum disturbs what lies around it: solving for the nodes near by, the others
/// held, gives the same poses, as long as the farther ones of them hardly move. So a closure in a known street costs
/// what it moves, however large the map is. What that leaves in the ones that are held goes with the next solution for
/// all nodes, of which a graph that grows needs only one for each tenth of it.
class Optimiser {
 public:
  explicit Optimiser(const OptimiserConfig& config = {}) : config_(config) {}

  /// Changes the graph's poses; leaves them as they were if the problem cannot be solved.
  OptimiserReport optimise(PoseGraph& graph);
  /// The same where a graph that was at its optimum was changed at the nodes `around`.
  OptimiserReport optimise(PoseGraph& graph, std::span<const int> around);

 private:
  using Matrix = Eigen::SparseMatrix<double>;
  struct Block {
    int diagonal_from[3], diagonal_to[3], off_diagonal[3];  // first value of each column in the matrix; -1: fixed node
    bool transposed;                                        // off-diagonal block lies at (to, from)
  };

  OptimiserReport solve(PoseGraph& graph, std::vector<int> nodes);
  void analyse(const PoseGraph& graph, std::vector<int> nodes);
  double linearise(const PoseGraph& graph, std::span<const Pose2> poses);
  double cost(const PoseGraph& graph, std::span<const Pose2> poses) const;
  double robustCost(const Edge& edge, double chi_square) const;

  OptimiserConfig config_;
  int solved_ = 0;                  // nodes when all were solved for
  std::vector<int> nodes_, edges_;  // that are solved for, and all their edges, in rising order
  Matrix H_;
  Eigen::VectorXd g_;
  std::vector<int> first_row_;  // by node; -1: fixed
  std::vector<Block> blocks_;   // as edges_
  std::vector<int> diagonal_;   // value of each diagonal entry
  Eigen::SimplicialLLT<Matrix, Eigen::Upper, Eigen::NaturalOrdering<int>> cholesky_;
};

}  // namespace slam
