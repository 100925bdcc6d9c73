// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>

#include "core/pose2.hpp"

namespace slam {

struct AlignMapConfig {
  double lever = 5.0;  ///< [m] at which a node's rotation is taken for a motion: what it saw lies so far around it
  double least_move = 0.005;  ///< [m] a node that moved by less did not move; no node is known better
  int max_iterations = 10;
  double converged = 1e-5;  ///< [m, rad] a step below this is the last
};

/// A pose graph's edges tell where its nodes lie relative to each other, and not where in map: that is the gauge
/// freedom. Holding one node would let all that lies behind it swing with each loop that closes, also what the loop
/// says nothing about; so the map is laid where the sum of its nodes' motions is least, and a part that keeps its
/// shape keeps its place while the larger part of the map does. A motion is a nuisance by its metres (of what was drawn
/// and of goals) and untrue by its standard deviations: it counts by their geometric mean, so that what is known to a
/// centimetre stays while what has drifted by decimetres moves. By iteratively reweighted least squares, whose weights
/// fall with a node's motion.
///
/// @param T_map_node as published before; empty or of another size than the next: identity
/// @param T_new_node as optimised, in any frame
/// @param sigma [m] of each node's position relative to where the map began; of another size: all alike
/// @return T_map_new
Pose2 alignToPreviousMap(std::span<const Pose2> T_map_node, std::span<const Pose2> T_new_node,
                         std::span<const double> sigma = {}, const AlignMapConfig& config = {});

}  // namespace slam
