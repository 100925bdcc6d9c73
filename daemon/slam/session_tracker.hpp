// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "slam/back_end_config.hpp"
#include "slam/floor_decision.hpp"
#include "slam/keyframe_map.hpp"

namespace slam {

/// The present session: the keyframes since the robot's place was lost or given the last time. Looks for its place in
/// the map as long as that is not known.
class SessionTracker {
 public:
  explicit SessionTracker(const BackEndConfig& config) : config_(config) {}

  /// A robot begins in a stored map: it has to be found there, or in one of the others.
  void load(const KeyframeMap& map, Floors floors = {});
  /// @param first keyframe of the session, which is in the map's keyframes already
  /// @param map_stays no keyframe was put into the map since the session before
  void begin(const Keyframe& first, const KeyframeMap& map, bool map_stays);

  struct Finding {
    std::optional<Relocalisation::Found> found;
    bool refuted = false;                      ///< it is not where a person said, or where it was assumed
    std::optional<FloorFound> elsewhere = {};  ///< it is in another map
  };
  /// Looks for the newest keyframe. @pre !placed()
  /// @param mapped the map holds what is seen from there, so that it may contradict a person
  Finding find(const KeyframeMap& map, bool mapped);
  /// So many scans were used since this was called the last time.
  void allowFor(std::int64_t scans) {
    if (relocalisation_) relocalisation_->allowFor(scans);
  }
  /// Whether a search waits to go on.
  bool searchUnderWay() const { return searchesAllOver() && relocalisation_ && relocalisation_->underWay(); }
  /// Its keyframes lie where they are in the map.
  void place() { state_ = State::kPlaced; }

  int first() const { return first_; }  ///< keyframe
  std::int32_t number() const { return number_; }
  bool placed() const { return state_ == State::kPlaced; }
  /// Where it is in each of the maps of which it may be in any, by rising names; empty: nothing speaks for several.
  std::vector<FloorFound> floorDoubt() const;
  /// What the newest search over the whole map found. @pre there was one
  const PlaceSearch::Result& newestSearch() const { return relocalisation_->newest(); }
  void addTo(BackEndCounters& counters) const;

 private:
  enum class State : std::uint8_t { kPlaced, kGiven, kAssumed, kLost };

  Finding findFloor(const KeyframeMap& map, bool mapped);
  bool searchesAllOver() const { return state_ == State::kAssumed || state_ == State::kLost; }

  BackEndConfig config_;
  FloorDecision floors_{Floors{}};
  std::optional<Relocalisation> relocalisation_;  // made when needed: its tables are large
  int first_ = 0;
  double heading_tolerance_ = std::numbers::pi;  // [rad] of it in the map
  std::int32_t number_ = 0;
  State state_ = State::kPlaced;
};

}  // namespace slam
