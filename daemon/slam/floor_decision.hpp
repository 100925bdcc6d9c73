// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "relocalisation/floor_atlas.hpp"
#include "relocalisation/relocalisation.hpp"

namespace slam {

/// In which of several maps a lost robot is. One search decides nothing: the one after it, which the robot has driven
/// on for, must find the session at the same place of the same map.
class FloorDecision {
 public:
  explicit FloorDecision(Floors floors) : floors_(std::move(floors)) {}

  bool hasOthers() const { return !floors_.others.empty(); }
  const Floors& floors() const { return floors_; }
  /// All maps as one, for the search. @param ids keyframes of the present map
  std::shared_ptr<const FloorAtlas> atlas(const KeyframeGraph& present, std::span<const int> ids, double gap) {
    return atlas_ = std::make_shared<const FloorAtlas>(present, ids, floors_, gap);
  }
  /// A session begins.
  void begin() {
    candidate_.reset();
    doubt_.clear();
  }

  /// Takes a search that has ended. @param found by it, in the atlas @param T_session_newest the newest keyframe
  /// @return where the session is, when it is decided
  std::optional<FloorAtlas::Place> decide(const Relocalisation& search,
                                          const std::optional<Relocalisation::Found>& found,
                                          const Pose2& T_session_newest) {
    doubt_ = doubtOf(search.newest());
    if (!found) return candidate_.reset(), std::nullopt;
    FloorAtlas::Place place = atlas_->placeOf(found->T_map_newest);
    const Pose2 T_floor_session = place.T_floor_base * T_session_newest.inverse();
    const auto before =
        std::exchange(candidate_, FloorAtlas::Place{.floor = place.floor, .T_floor_base = T_floor_session});
    const bool agree = before && before->floor == place.floor &&
                       search.same(before->T_floor_base * T_session_newest, place.T_floor_base);
    return agree ? std::optional(place) : std::nullopt;
  }

  /// The maps that explain the scans alike, as far as the newest search shows, likeliest first; empty: there are not
  /// two.
  const std::vector<int>& doubt() const { return doubt_; }

 private:
  std::vector<int> doubtOf(const PlaceSearch::Result& newest) const {
    if (newest.outcome != PlaceSearch::Outcome::kAmbiguous) return {};
    std::vector<int> floors{atlas_->placeOf(newest.T_map_newest).floor};
    for (const Pose2& rival : newest.T_map_rivals) {
      const int floor = atlas_->placeOf(rival).floor;
      if (std::find(floors.begin(), floors.end(), floor) == floors.end()) floors.push_back(floor);
    }
    return floors.size() > 1 ? floors : std::vector<int>{};
  }

  Floors floors_;
  std::shared_ptr<const FloorAtlas> atlas_;
  std::optional<FloorAtlas::Place> candidate_;  // of the session's frame, by the search before
  std::vector<int> doubt_;
};

}  // namespace slam
