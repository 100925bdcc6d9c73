// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <vector>

#include "core/keyframe.hpp"
#include "posegraph/keyframe_graph.hpp"
#include "posegraph/loop_closure.hpp"
#include "posegraph/optimiser.hpp"
#include "slam/map_correction.hpp"
#include "slam/mapper.hpp"

namespace slam {

struct BackEndConfig {
  LoopClosureConfig closure;
  OptimiserConfig optimiser;
  ReferenceConfig reference;
  MatchConfig match;
  bool close_loops = true;
  double link_distance = 1.0;  ///< [m] a new keyframe is joined to the nearest of the reference up to here ...
  int link_age = 10;           ///< ... that is so many keyframes older: both were matched to one reference
  double link_translation_sigma = 0.02;  ///< [m] of such an edge
  double link_rotation_sigma = 0.005;    ///< [rad]
  double reference_radius = 25.0;        ///< [m] keyframes this near to the robot are put into its reference
  double renewal_radius = 8.0;           ///< [m] what becomes known or unknown within this distance renews it
  double renewal_shift = 0.01;           ///< [m] a keyframe of the reference that moved further renews it
};

struct BackEndCounters {
  int keyframes = 0, loop_closures = 0, revoked = 0, optimisations = 0, corrections = 0;
  LoopClosureSearch::Counters search;
};

/// The back end: keyframes and what joins them. Closes loops, optimises the graph, and decides which part of the map
/// the front end may match against: the keyframes whose position relative to the robot is known. Old ones that the
/// robot's drift has lost touch with come back only when a loop closure has put them in place, so that two copies of
/// one wall never pull at a scan.
///
/// No thread, clock or I/O. Allocates. Not safe for concurrent use.
class BackEnd {
 public:
  explicit BackEnd(const BackEndConfig& config);

  /// Takes a keyframe (ids count from 0 without gaps) or a look.
  /// @param may_correct false: no correction is made, because the last one is still on its way
  void add(const Keyframe& keyframe, bool may_correct = true);

  /// The keyframe or look just added, for the Mapper, at its pose as known now.
  MapScan mapScan(const Keyframe& keyframe) const;

  /// The correction that has become due, if any; give used ones back to recycle their memory.
  std::unique_ptr<MapCorrection> takeCorrection();
  void recycle(std::unique_ptr<MapCorrection> used) { spare_ = std::move(used); }

  const KeyframeGraph& keyframes() const { return keyframes_; }
  /// Counts up whenever poses of known keyframes changed.
  int generation() const { return generation_; }
  const BackEndCounters& counters() const { return counters_; }

 private:
  void closeLoops();
  void revokeContradicted();
  void linkToReference();
  void renewReferenceIfStale(int anchor);
  void renewReference(int anchor, const std::vector<int>& active);

  BackEndConfig config_;
  KeyframeGraph keyframes_;
  LoopClosureSearch search_;
  Optimiser optimiser_;
  std::vector<Pose2> in_reference_;    // pose of each keyframe in the front end's reference ...
  std::vector<char> is_in_reference_;  // ... where this is set
  std::unique_ptr<MapCorrection> due_, spare_;
  int generation_ = 0;
  BackEndCounters counters_;
};

}  // namespace slam
