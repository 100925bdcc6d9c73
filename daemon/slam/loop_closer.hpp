// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "slam/back_end_config.hpp"
#include "slam/keyframe_map.hpp"

namespace slam {

/// Closes loops: optimises the graph with what the search finds, takes back closures that contradict the rest, and lays
/// the map where it as a whole moves least (alignToPreviousMap).
class LoopCloser {
 public:
  explicit LoopCloser(const BackEndConfig& config);

  /// Where the newest keyframe has come back to an old part of the map, its poses change, and its generation.
  void close(KeyframeMap& map);
  void addTo(BackEndCounters& counters) const;

 private:
  /// @return whether all of it moved
  bool optimise(PoseGraph& graph, std::span<const int> around);
  bool revokeContradicted(PoseGraph& graph);

  double max_chi_square_;
  LoopClosureSearch search_;
  Optimiser optimiser_;
  int closed_ = 0, revoked_ = 0, optimisations_ = 0;
};

}  // namespace slam
