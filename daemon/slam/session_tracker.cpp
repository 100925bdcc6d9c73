// SPDX-License-Identifier: BSD-3-Clause
#include "slam/session_tracker.hpp"

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

void SessionTracker::load(const KeyframeMap& map) {
  first_ = map.given;
  if (map.given > 0) state_ = State::kLost;
}

void SessionTracker::begin(const Keyframe& first, const KeyframeMap& map, bool map_stays) {
  first_ = first.id;
  number_ = first.session;
  heading_tolerance_ = first.heading_tolerance;
  state_ = first.origin == KeyframeOrigin::kGiven ? State::kGiven : State::kLost;
  const bool ready = relocalisation_ && map_stays;  // the search's pyramid stays good
  if (!relocalisation_) relocalisation_.emplace(config_.relocalisation, config_.reference, config_.match);
  ready ? relocalisation_->begin() : relocalisation_->begin(map.keyframes, map.idsInMap());
}

SessionTracker::Finding SessionTracker::find(const KeyframeMap& map, bool map_knows) {
  const int newest = map.newest();
  if (state_ == State::kLost)
    return {.found = relocalisation_->search(map.keyframes, first_, newest, heading_tolerance_)};
  Finding finding{.found = relocalisation_->searchNear(map.keyframes, first_, newest, kGivenWindow)};
  if (finding.found || newest - first_ + 1 < config_.given_attempts) return finding;
  if (map_knows) {  // it does not look as it should: the robot may be anywhere
    state_ = State::kLost;
    finding.refuted = true;
  } else {  // the map says nothing about the place: the person's word counts
    finding.found = asGiven(map.keyframes.pose(newest));
  }
  return finding;
}

void SessionTracker::addTo(BackEndCounters& counters) const {
  if (relocalisation_) counters.relocalisation = relocalisation_->counters();
}

}  // namespace slam
