// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "app/channels.hpp"
#include "app/log/trouble_log.hpp"
#include "app/map/store_policy.hpp"
#include "config/config.hpp"
#include "frontend/front_end.hpp"
#include "problems/problem.hpp"
#include "runtime/clock.hpp"
#include "slam/map_builder.hpp"

namespace slam {

/// The map that the graph thread works on: puts keyframes into the pose graph, closes loops, and hands corrections to
/// the estimator and what is to be drawn to the mapper. Belongs to that thread.
class GraphWork {
 public:
  /// Call beginIn() before anything else. @param policy is given what is to be stored beside the pose graph
  GraphWork(const Config& config, const GraphEnds& ends, const WallClock& clock, StorePolicy& policy);

  /// Changes to another map. @param localise it stays as it is
  void beginIn(MapState map, bool localise);
  /// A front end that begins in this map.
  std::unique_ptr<FrontEnd> newFrontEnd() const;

  /// Takes what the estimator hands over and gives back.
  void tick();
  /// Takes the keyframes and depth images alone.
  void takeIn();
  /// To the mapper, as far as it has room.
  void sendChanges();
  void requestGrid();
  /// Makes or undoes an edit. A place without a pose is where the robot is.
  /// @param done out: id of the edit @return why not; none: it is done
  Problem edit(EditCommand command, int* done);

  const auto& backEnd() const { return builder_->backEnd(); }
  const Pose2& lastPose() const { return robot_.T_map_base; }
  /// Where the front end has the robot, in its session's frame while it is lost.
  const Pose2& trackedPose() const { return snapshot_.pose.T_map_base; }
  /// The other map that the robot was found in, once; none where it is in another session by now.
  std::shared_ptr<const FloorFound> takeFloor();
  /// Where the robot is in a map of which it is not known whether it is in that one; none where it is not in doubt.
  std::optional<Pose2> placeIn(const std::string& map) const;
  /// Whether that holds still.
  bool isInSession(const FloorFound& floor) const { return backEnd().session() == floor.session; }
  /// The maps of which the robot may be in any. From any thread.
  Problem floorDoubt() const { return search_.doubt.load(); }
  bool isLocalised() const { return snapshot_.pose.state == LocalisationState::kLocalised; }
  /// Counts up with whatever the stored map should show.
  std::int64_t changes() const;
  /// As it is to be stored. @param drawn_keyframes so many are in the grid
  MapState state(DrawnMap drawn, int drawn_keyframes) const;

 private:
  void followPose();
  void showEdits();
  void add(const Keyframe& keyframe);
  void add(const DepthObservation& sight);
  void followFloor(const MapUpdate& update);
  void logEvents(const MapUpdate& update, const BackEndCounters& counters);
  void send(std::unique_ptr<MapCorrection> correction);
  MapChange& addChange(Timestamp stamp);

  const Config& config_;
  const GraphEnds& ends_;
  const WallClock& clock_;
  StorePolicy& policy_;
  FrontEndConfig front_end_config_;  // fitted to the map
  FrontEndStart start_;
  struct Search {
    bool without_map = false;                 // to localise in
    std::shared_ptr<const FloorFound> floor;  // another map that the robot is in
    SharedProblem doubt;                      // between maps
  } search_;
  std::unique_ptr<MapBuilder> builder_;
  BackEndCounters earlier_;  // counted in the maps before
  PoseSnapshot snapshot_;
  std::int64_t seen_scans_ = 0;  // of it, that the search for a lost robot was allowed for
  struct Robot {
    Pose2 T_map_base;        // the last one that was valid
    double gyro_bias = 0.0;  // [rad/s]
    BodyShape body;          // what moves with it
  } robot_;
  EditMessages edits_;                              // not yet in the bus's queue
  std::deque<std::shared_ptr<MapChange>> changes_;  // not yet in the mapper's queue
  TroubleLog log_;
};

}  // namespace slam
