// SPDX-License-Identifier: BSD-3-Clause
#include "slam/session_tracker.hpp"

#include <algorithm>

namespace slam {
namespace {

const Eigen::Vector3d kGivenSigma(0.2, 0.2, 0.1);  // [m, m, rad]
constexpr SearchWindow kGivenWindow{1.0, 0.6};     // around a pose that a person gave

Relocalisation::Found asGiven(const Pose2& T_map_newest) {
  Relocalisation::Found found{T_map_newest, {}};
  found.match.T_ref_base = T_map_newest;
  found.match.covariance = kGivenSigma.cwiseAbs2().asDiagonal();
  found.match.directions.setIdentity();
  found.match.observable = 3;
  return found;
}

}  // namespace

void SessionTracker::load(const KeyframeMap& map, Floors floors) {
  first_ = map.given;
  floors_ = FloorDecision(std::move(floors));
  if (map.given > 0) state_ = State::kLost;
}

void SessionTracker::begin(const Keyframe& first, const KeyframeMap& map, bool map_stays) {
  first_ = first.id;
  number_ = first.session;
  heading_tolerance_ = first.heading_tolerance;
  state_ = first.origin == KeyframeOrigin::kGiven     ? State::kGiven
           : first.origin == KeyframeOrigin::kAssumed ? State::kAssumed
                                                      : State::kLost;
  const bool ready = relocalisation_ && map_stays;  // the search's pyramid stays good
  if (!relocalisation_) relocalisation_.emplace(config_.relocalisation, config_.reference, config_.match);
  floors_.begin(number_);
  if (ready) return relocalisation_->begin();
  if (!floors_.hasOthers()) return relocalisation_->begin(map.keyframes, map.idsInMap());
  relocalisation_->begin(floors_.atlas(map.keyframes, map.idsInMap(), config_.relocalisation.floor_gap));
}

SessionTracker::Finding SessionTracker::find(const KeyframeMap& map, bool mapped) {
  const int newest = map.newest();
  if (searchesAllOver() && floors_.hasOthers()) return findFloor(map, mapped);
  if (searchesAllOver()) return {.found = relocalisation_->search(map.keyframes, first_, newest, heading_tolerance_)};
  Finding finding{.found = relocalisation_->searchNear(map.keyframes, first_, newest, kGivenWindow)};
  if (finding.found || newest - first_ + 1 < config_.given_attempts) return finding;
  if (mapped) {  // it does not look as it should: the robot may be anywhere
    state_ = State::kLost;
    finding.refuted = true;
  } else {  // the map does not hold the place: the person's word counts
    finding.found = asGiven(map.keyframes.pose(newest));
  }
  return finding;
}

/// Nothing is known of the session's heading in another map.
SessionTracker::Finding SessionTracker::findFloor(const KeyframeMap& map, bool mapped) {
  const int searches = relocalisation_->counters().searches;
  const Pose2& T_session_newest = map.keyframes.pose(map.newest());
  const auto found = relocalisation_->search(map.keyframes, first_, map.newest());
  if (relocalisation_->counters().searches == searches) return {};
  const auto place = floors_.decide(*relocalisation_, found, T_session_newest);
  if (!place && state_ == State::kAssumed && mapped && floors_.nowhere() >= config_.given_attempts) {
    state_ = State::kLost;  // what it sees is in none of the maps
    return {.found = {}, .refuted = true};
  }
  if (!place) return {};
  if (place->floor == 0) return {.found = found};
  return {.found = {},
          .elsewhere = FloorFound{floors_.floors().name(place->floor), number_,
                                  place->T_floor_base * T_session_newest.inverse()}};
}

std::vector<FloorFound> SessionTracker::floorDoubt() const {
  if (!searchesAllOver()) return {};
  std::vector<FloorFound> floors = floors_.doubt();
  std::sort(floors.begin(), floors.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return floors;
}

void SessionTracker::addTo(BackEndCounters& counters) const {
  if (relocalisation_) counters.relocalisation = relocalisation_->counters();
}

}  // namespace slam
