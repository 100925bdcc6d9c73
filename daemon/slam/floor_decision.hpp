// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
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
  /// A session begins. @param session its number
  void begin(std::int32_t session) {
    session_ = session;
    candidate_.reset();
    doubt_.clear();
    nowhere_ = 0;
  }

  /// Takes a search that has ended. @param found by it, in the atlas @param T_session_newest the newest keyframe
  /// @return where the session is, when it is decided
  std::optional<FloorAtlas::Place> decide(const Relocalisation& search,
                                          const std::optional<Relocalisation::Found>& found,
                                          const Pose2& T_session_newest) {
    doubt_ = doubtOf(search.newest(), T_session_newest);
    nowhere_ = search.newest().outcome == PlaceSearch::Outcome::kElsewhere ? nowhere_ + 1 : 0;
    if (!found) return candidate_.reset(), std::nullopt;
    FloorAtlas::Place place = atlas_->placeOf(found->T_map_newest);
    const Pose2 T_floor_session = place.T_floor_base * T_session_newest.inverse();
    const auto before =
        std::exchange(candidate_, FloorAtlas::Place{.floor = place.floor, .T_floor_base = T_floor_session});
    const bool agree = before && before->floor == place.floor &&
                       search.same(before->T_floor_base * T_session_newest, place.T_floor_base);
    return agree ? std::optional(place) : std::nullopt;
  }

  /// Where the session is in each of the maps that explain the scans alike, as far as the newest search shows,
  /// likeliest first; empty: there are not two.
  const std::vector<FloorFound>& doubt() const { return doubt_; }
  /// Searches in a row by which it is in none of the maps.
  int nowhere() const { return nowhere_; }

 private:
  std::vector<FloorFound> doubtOf(const PlaceSearch::Result& newest, const Pose2& T_session_newest) const {
    if (newest.outcome != PlaceSearch::Outcome::kAmbiguous) return {};
    std::vector<FloorFound> floors;
    std::vector<char> seen(floors_.others.size() + 1);
    const auto take = [&](const Pose2& T_atlas_newest) {
      const FloorAtlas::Place place = atlas_->placeOf(T_atlas_newest);
      if (std::exchange(seen[static_cast<std::size_t>(place.floor)], 1)) return;
      floors.push_back({.name = floors_.name(place.floor),
                        .session = session_,
                        .T_floor_session = place.T_floor_base * T_session_newest.inverse()});
    };
    take(newest.T_map_newest);
    for (const Pose2& rival : newest.T_map_rivals) take(rival);
    return floors.size() > 1 ? floors : std::vector<FloorFound>{};
  }

  Floors floors_;
  std::shared_ptr<const FloorAtlas> atlas_;
  std::optional<FloorAtlas::Place> candidate_;  // of the session's frame, by the search before
  std::vector<FloorFound> doubt_;
  int nowhere_ = 0;
  std::int32_t session_ = 0;
};

}  // namespace slam
