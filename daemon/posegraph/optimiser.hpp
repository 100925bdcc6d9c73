// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "posegraph/pose_graph.hpp"

namespace slam {

struct OptimiserConfig {
  int max_iterations = 20;
  double relative_tolerance = 1e-5;  ///< [1] a step that lowers the cost by a smaller share has converged
  double step_tolerance = 1e-5;      ///< [m, rad] largest change of a node in a step that has converged
  double kernel_scale = 3.0;         ///< [1] Mahalanobis distance at which a loop closure has lost half its weight
};

struct OptimiserReport {
  bool converged = false;  ///< false: the poses are as good as the iterations allowed, or as before if it failed
  int iterations = 0;
  double cost_before = 0.0, cost_after = 0.0;  ///< half the robust sum of squares [1]
};

/// Sparse nonlinear least squares over the poses of a graph:
///
///     min sum_motion |e|^2 + sum_closures s^2 log(1 + |e|^2/s^2),    e = T_from_to^-1 * (T_from^-1 * T_to)
///
/// by Gauss-Newton with Levenberg's damping; node 0 stays. Each step factorises the normal equations by a sparse
/// Cholesky decomposition whose ordering and symbolic part are kept while the graph keeps its edges.
/// [Grisetti 2010] G. Grisetti et al., "A tutorial on graph-based SLAM", IEEE ITS Magazine 2(4).
/// Cauchy's kernel gives wrong closures little weight [Agarwal 2013, Lee 2013].
class Optimiser {
 public:
  explicit Optimiser(const OptimiserConfig& config = {}) : config_(config) {}

  /// Changes the graph's poses; leaves them as they were if the problem cannot be solved.
  OptimiserReport optimise(PoseGraph& graph);

 private:
  using Matrix = Eigen::SparseMatrix<double>;
  struct Block {
    int diagonal_from[3], diagonal_to[3], off_diagonal[3];  // first value of each column in the matrix; -1: fixed node
    bool transposed;                                        // off-diagonal block lies at (to, from)
  };

  void analyse(const PoseGraph& graph);
  double linearise(const PoseGraph& graph, std::span<const Pose2> poses);
  double cost(const PoseGraph& graph, std::span<const Pose2> poses) const;
  double robustCost(const Edge& edge, double chi_square) const;

  OptimiserConfig config_;
  std::size_t analysed_edges_ = 0;
  int analysed_nodes_ = 0;
  Matrix H_;
  Eigen::VectorXd g_;
  std::vector<int> first_row_;  // by node; -1: fixed
  std::vector<Block> blocks_;
  std::vector<int> diagonal_;  // value of each diagonal entry
  Eigen::SimplicialLLT<Matrix, Eigen::Upper, Eigen::NaturalOrdering<int>> cholesky_;
};

}  // namespace slam
