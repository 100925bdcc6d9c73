// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/keyframe.hpp"
#include "core/pseudo_laser.hpp"
#include "mapping/mapper.hpp"
#include "slam/map_policy.hpp"

namespace slam {

/// The back end: keyframes and what joins them. A robot that is lost maps a session of its own, which is looked for in
/// the map; only when it is found there do its keyframes become part of the map. See the parts for the rest.
///
/// No thread, clock or I/O. Allocates. Not safe for concurrent use.
class BackEnd {
 public:
  explicit BackEnd(const BackEndConfig& config);
  BackEnd(const BackEnd&) = delete;
  BackEnd& operator=(const BackEnd&) = delete;

  /// Goes on in a stored map: the robot has to be found in it, or in one of the others. Before the first add().
  void load(KeyframeGraph map, const std::vector<char>& in_map, const MapEdits& edits = {}, const Floors& floors = {});

  /// Takes a keyframe (ids count from 0, or from the size of the map loaded, without gaps) or a refresh.
  /// @param may_correct false: no correction is made, because the last one is still on its way
  void add(const Keyframe& keyframe, bool may_correct = true);

  /// Makes or undoes an edit; see KeyframeMap. The front end's reference follows with the next correction.
  Problem edit(const EditCommand& command, const Eigen::Vector2d& robot, std::vector<int>* changed, int* concerned) {
    return map_.edit(command, robot, changed, concerned);
  }

  /// So many scans were used since this was called the last time: the search for a lost robot may do as much work.
  void allowFor(std::int64_t scans) { session_.allowFor(scans); }

  /// What the keyframe or refresh just added gives the Mapper to draw, at its pose as known now: nothing while the
  /// robot is lost or in a map that is only given, the whole session when it has been found. Also keyframes that were
  /// drawn, but whose points have become fewer.
  std::vector<MapScan> mapScans(const Keyframe& keyframe) const;
  /// The same of a depth image.
  std::optional<MapView> mapView(const DepthObservation& sight) const;

  /// The correction that has become due, if any; give used ones back to recycle their memory.
  std::unique_ptr<MapCorrection> takeCorrection() { return reference_.take(); }
  void recycle(std::unique_ptr<MapCorrection> used) { reference_.recycle(std::move(used)); }

  const KeyframeMap& map() const { return map_; }
  const KeyframeGraph& keyframes() const { return map_.keyframes; }
  /// Counts up whenever poses or points of known keyframes changed.
  int generation() const { return map_.generation; }
  /// Whether the front end's reference holds a keyframe, once all corrections have reached it.
  bool inReference(int id) const { return map_.inReference(id); }
  BackEndCounters counters() const;
  /// The other map that the last add() has found the robot in, if it has. Its keyframes come into neither map.
  const std::optional<FloorFound>& elsewhere() const { return elsewhere_; }
  std::int32_t session() const { return session_.number(); }
  /// See SessionTracker.
  std::vector<FloorFound> floorDoubt() const { return session_.floorDoubt(); }
  /// What the newest search for a lost robot found. @pre counters().relocalisation.searches > 0
  const PlaceSearch::Result& newestSearch() const { return session_.newestSearch(); }

 private:
  void findSession();
  void place(const Relocalisation::Found& found);
  bool draws(std::int32_t session) const;

  Pose2 T_base_depth_;
  KeyframeMap map_;
  ReferenceSelector reference_;
  SessionTracker session_;
  std::unique_ptr<MapPolicy> policy_;
  std::optional<FloorFound> elsewhere_;  // by the last add()
  int first_placed_ = 0;                 // keyframe that the last add() put into the map; those behind it, too
  bool cleared_ = false;                 // the keyframes of this run have lost points since they were drawn
  int keyframes_ = 0, placed_ = 0, begun_anew_ = 0;
};

}  // namespace slam
