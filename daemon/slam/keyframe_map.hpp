// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/pose_covariance.hpp"
#include "frontend/map_correction.hpp"
#include "graph/keyframe_graph.hpp"
#include "slam/edits/map_edits.hpp"

namespace slam {

/// A session that was found in the map and is tied to it, but no part of it yet.
struct ProvisionalJoin {
  int first = 0;            ///< keyframe of the session
  int first_edge = 0;       ///< that was added since
  double remaining = 0.0;   ///< [m] to drive, without getting lost, until it is part of the map
  Eigen::Vector2d p_robot;  ///< [m] in map

  /// @return whether it may be part of the map, now that the robot is here [m]
  bool driveTo(const Eigen::Vector2d& p_map) {
    remaining -= (p_map - std::exchange(p_robot, p_map)).norm();
    return remaining <= 0.0;
  }

  /// What ties the session to the map counts for nothing.
  void revoke(PoseGraph& graph) const {
    for (int id = first_edge; id < std::ssize(graph.edges()); ++id) {
      if (graph.edges()[static_cast<std::size_t>(id)].from < first) graph.revoke(id);
    }
  }
};

/// The keyframes of the map, and those of a session whose place in it is not known yet.
struct KeyframeMap {
  KeyframeGraph keyframes;
  std::vector<char> in_map;                     ///< by id: its place in the map is known
  std::vector<ReferenceKeyframe> in_reference;  ///< those of the front end's reference, by id
  int given = 0;                                ///< keyframes of the stored map that this goes on in
  int first_in_map = 0;                         ///< the ones before are forgotten
  int generation = 0;                           ///< counts up whenever poses or points of known keyframes changed
  std::optional<ProvisionalJoin> join;          ///< of the newest session
  BodyShape body;                               ///< what moves with the robot, as far as it is known
  int cleared = 0;                              ///< the scans of keyframes before it were looked through for it
  bool reference_cleared = true;                ///< so was the front end's reference
  MapEdits edits;

  /// Goes on in a stored map. Before anything is added.
  void load(KeyframeGraph map, std::vector<char> known) {
    keyframes = std::move(map);
    given = keyframes.size();
    in_map = std::move(known);
  }
  /// Takes a keyframe that goes on from the newest one. The front end has put it into its reference itself.
  void add(const Keyframe& keyframe, bool known) {
    keyframes.add(keyframe);
    in_map.push_back(known && !join ? 1 : 0);
    in_reference.push_back({keyframe.id, keyframes.pose(keyframe.id)});
  }
  /// Takes the first keyframe of a session. The front end's reference begins with it.
  void begin(const Keyframe& keyframe) {
    keyframes.add(std::make_shared<const StoredScan>(keyframe), keyframe.T_map_base);
    in_map.push_back(0);
    in_reference = {{keyframe.id, keyframe.T_map_base}};
  }
  /// Takes what turns out to move with the robot out of the scans of this run. It was there from the first one on: what
  /// some of them do not show is a wall that a robot drives along, or was put on later.
  /// @return whether there was any
  bool leaveOut(const Keyframe& known) {
    const BodyShape found = known.body.without(body);
    body = known.body;
    if (found.degrees() == 0) return false;
    std::vector<std::shared_ptr<const StoredScan>> scans;
    bool any = false;
    for (int id = newest(); id >= given; --id) {
      scans.push_back(scanWithout(keyframes.scan(id), found, known.body_margin));
      const bool shows = scans.back() != keyframes.scan(id);
      if (id >= cleared && !shows) return false;
      any |= shows;
    }
    if (!any) return false;
    for (int id = given; id <= newest(); ++id) {
      keyframes.setScan(id, std::move(scans.back()));
      scans.pop_back();
    }
    for (auto& [id, scan] : edits.whole) {
      if (id >= given) scan = scanWithout(scan, found, known.body_margin);
    }
    cleared = keyframes.size();
    reference_cleared = false;
    ++generation;
    return true;
  }
  /// Makes or undoes an edit. @param robot [m] in map @param changed out: keyframes whose points changed
  /// @param concerned out: id of the edit that came or went @return why not, in words; empty: it is done
  Problem edit(const EditCommand& command, const Eigen::Vector2d& robot, std::vector<int>* changed, int* concerned);
  /// Forgets all but the map that was loaded.
  void truncate() {
    keyframes.truncate(given);
    cleared = given;
    in_map.resize(static_cast<std::size_t>(given));
    std::erase_if(in_reference, [this](const ReferenceKeyframe& keyframe) { return keyframe.id >= given; });
  }

  /// The poses from keyframe `first` on, known so far from the session's own beginning, are as uncertain in map as the
  /// keyframe that it was joined at makes them.
  void addUncertaintyOf(int joined_at, int first) {
    for (int id = first; id < keyframes.size(); ++id) {
      auto scan = std::make_shared<StoredScan>(*keyframes.scan(id));
      const Pose2 T_joined_id = between(keyframes.pose(joined_at), keyframes.pose(id));
      scan->covariance += carried(keyframes.scan(joined_at)->covariance, T_joined_id);
      keyframes.setScan(id, std::move(scan));
    }
  }
  /// The session from keyframe `first` on is part of the map.
  void take(int first) {
    std::fill(in_map.begin() + first, in_map.end(), 1);
    ++generation;
  }
  void confirmJoin() {
    take(join->first);
    join.reset();
  }
  /// The map is as before the join. @return whether there was one
  bool undoJoin() {
    if (!join) return false;
    join->revoke(keyframes.graph());
    join.reset();
    return true;
  }

  /// Of a keyframe or refresh, in map.
  Pose2 poseOf(const Keyframe& keyframe) const {
    const Pose2& T_map_keyframe = keyframes.pose(keyframe.id);
    return keyframe.refresh ? T_map_keyframe * keyframe.T_previous_base : T_map_keyframe;
  }
  int newest() const { return keyframes.size() - 1; }
  bool inReference(int id) const {
    return std::binary_search(in_reference.begin(), in_reference.end(), ReferenceKeyframe{id, {}, {}},
                              [](const auto& a, const auto& b) { return a.id < b.id; });
  }
  bool inMap(int id) const { return in_map[static_cast<std::size_t>(id)] != 0; }
  std::vector<int> idsInMap() const {
    std::vector<int> ids;
    for (int id = 0; id < keyframes.size(); ++id) {
      if (inMap(id)) ids.push_back(id);
    }
    return ids;
  }
};

}  // namespace slam
