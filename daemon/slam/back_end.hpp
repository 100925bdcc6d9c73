// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "core/keyframe.hpp"
#include "core/pseudo_laser.hpp"
#include "posegraph/keyframe_graph.hpp"
#include "posegraph/loop_closure.hpp"
#include "posegraph/optimiser.hpp"
#include "posegraph/relocalisation.hpp"
#include "slam/map_correction.hpp"
#include "slam/mapper.hpp"

namespace slam {

struct BackEndConfig {
  LoopClosureConfig closure;
  RelocalisationConfig relocalisation;
  OptimiserConfig optimiser;
  ReferenceConfig reference;
  MatchConfig match;
  bool close_loops = true;
  bool localise_only = false;  ///< the map stays as it was loaded
  Pose2 T_base_depth;          ///< of the levelled depth camera
  double link_distance = 1.0;  ///< [m] a new keyframe is joined to the nearest of the reference up to here ...
  int link_age = 10;           ///< ... that is so many keyframes older: both were matched to one reference
  double link_translation_sigma = 0.02;  ///< [m] of such an edge
  double link_rotation_sigma = 0.005;    ///< [rad]
  double reference_radius = 25.0;        ///< [m] keyframes this near to the robot are put into its reference
  double renewal_travel = 8.0;           ///< [m] in a given map the reference follows the robot in such steps
  int given_attempts = 3;                ///< keyframes that are compared with the map around a pose that a person gave
  double renewal_radius = 8.0;           ///< [m] what becomes known or unknown within this distance renews it
  int few_keyframes = 10;                ///< a map of no more, and made by this robot since its start, is forgotten ...
  double outgrown = 4.0;                 ///< ... for a segment that is not in it and has so many times its keyframes
  double renewal_shift = 0.01;           ///< [m] a keyframe of the reference that moved further renews it ...
  double renewal_turn = 0.01;            ///< [rad] ... or that turned by more: a robot may have turned on the spot
};

struct BackEndCounters {
  int keyframes = 0, loop_closures = 0, revoked = 0, optimisations = 0, corrections = 0;
  int placed = 0;      ///< segments found in the map
  int begun_anew = 0;  ///< maps of a few keyframes that a segment has outgrown
  LoopClosureSearch::Counters search;
  Relocalisation::Counters relocalisation;
};

/// The back end: keyframes and what joins them. Closes loops, optimises the graph, lays it where the map as a whole
/// moves least (holdGauge), and decides which part of the map the front end may match against: the keyframes whose
/// position relative to the robot is known. Old ones that the robot's drift has lost touch with come back only when a
/// loop closure has put them in place, so that two copies of one wall never pull at a scan.
///
/// A robot that is lost maps a segment of its own, which the back end looks for in the map; only when it is found there
/// do its keyframes become part of the map. A map of a few keyframes (a bad first scan, a robot that was switched on
/// while it was carried) is forgotten when a segment that was not found in it has outgrown it: the segment is the map.
///
/// No thread, clock or I/O. Allocates. Not safe for concurrent use.
class BackEnd {
 public:
  explicit BackEnd(const BackEndConfig& config);

  /// Goes on in a stored map: the robot has to be found in it. Before the first add().
  void load(KeyframeGraph map, std::vector<char> in_map);

  /// Takes a keyframe (ids count from 0, or from the size of the map loaded, without gaps) or a look.
  /// @param may_correct false: no correction is made, because the last one is still on its way
  void add(const Keyframe& keyframe, bool may_correct = true);

  /// What the keyframe or look just added gives the Mapper to draw, at its pose as known now: nothing while the robot
  /// is lost or in a map that is only given, the whole segment when it has been found.
  std::vector<MapScan> mapScans(const Keyframe& keyframe) const;
  /// The same of a depth image.
  std::optional<MapView> mapView(const DepthSight& sight) const;

  /// The correction that has become due, if any; give used ones back to recycle their memory.
  std::unique_ptr<MapCorrection> takeCorrection();
  void recycle(std::unique_ptr<MapCorrection> used) { spare_ = std::move(used); }

  const KeyframeGraph& keyframes() const { return keyframes_; }
  /// Whether a keyframe is part of the map; one of a segment that was not found yet is not.
  const std::vector<char>& inMap() const { return is_in_map_; }
  /// Keyframes before this one are no part of the map any more.
  int firstInMap() const { return first_in_map_; }
  bool inMap(int id) const { return is_in_map_[static_cast<std::size_t>(id)] != 0; }
  /// Whether the front end's reference holds a keyframe, once all corrections have reached it.
  bool inReference(int id) const { return is_in_reference_[static_cast<std::size_t>(id)] != 0; }
  /// Counts up whenever poses of known keyframes changed.
  int generation() const { return generation_; }
  const BackEndCounters& counters() const { return counters_; }
  /// What the newest search for a lost robot found. @pre counters().relocalisation.searches > 0
  const PlaceSearch::Result& newestSearch() const { return relocalisation_->newest(); }

 private:
  void beginSegment(const Keyframe& keyframe);
  void findSegment();
  bool outgrown() const;
  void beginAnew();
  void giveUpGivenPose(int newest);
  void placeSegment(const Relocalisation::Found& found);
  std::vector<int> mapIds() const;
  void followInGivenMap(const Eigen::Vector2d& robot);
  void closeLoops();
  void revokeContradicted();
  void holdMap(std::span<const Pose2> before);
  void linkToReference(const Keyframe& keyframe);
  void renewReferenceIfStale(int anchor);
  void renewReference(const Eigen::Vector2d& robot, const std::vector<int>& active);
  std::vector<int> knownFrom(int anchor) const;

  BackEndConfig config_;
  KeyframeGraph keyframes_;
  LoopClosureSearch search_;
  Optimiser optimiser_;
  std::optional<Relocalisation> relocalisation_;  // made when needed: its tables are large
  int given_size_ = 0;                            // keyframes of the map loaded
  int first_in_map_ = 0;                          // the ones before are forgotten
  int segment_first_ = 0;                         // first keyframe of the present segment ...
  std::int32_t segment_ = 0;                      // ... its number ...
  KeyframeOrigin segment_origin_ = KeyframeOrigin::kContinued;
  bool placed_ = true;    // ... and whether its place in the map is known
  int just_placed_ = -1;  // first keyframe of a segment that the last add() placed
  Eigen::Vector2d reference_centre_ = Eigen::Vector2d::Zero();  // [m] in a given map
  std::int32_t segment_of_reference_ = -1;
  std::vector<char> is_in_map_;        // by keyframe
  std::vector<Pose2> in_reference_;    // pose of each keyframe in the front end's reference ...
  std::vector<char> is_in_reference_;  // ... where this is set
  std::unique_ptr<MapCorrection> due_, spare_;
  int generation_ = 0;
  BackEndCounters counters_;
};

}  // namespace slam
