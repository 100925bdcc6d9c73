// SPDX-License-Identifier: BSD-3-Clause
#include "slam/back_end.hpp"

#include <algorithm>
#include <utility>

namespace slam {

BackEnd::BackEnd(const BackEndConfig& config)
    : T_base_depth_(config.T_base_depth),
      reference_(config),
      session_(config),
      policy_(mapPolicy(config, map_, reference_)) {}

void BackEnd::load(KeyframeGraph map, const std::vector<char>& in_map, const MapEdits& edits, const Floors& floors) {
  map_.load(std::move(map), in_map);
  map_.edits = edits;
  session_.load(map_, floors);
}

void BackEnd::add(const Keyframe& keyframe, bool may_correct) {
  elsewhere_.reset();
  const bool shown = draws(session_.number());
  cleared_ = map_.leaveOut(keyframe) || (cleared_ && !shown);
  first_placed_ = map_.keyframes.size();
  if (!keyframe.refresh) {
    ++keyframes_;
    first_placed_ = keyframe.id;
    if (keyframe.origin == KeyframeOrigin::kContinued) {
      map_.add(keyframe, session_.placed());
    } else {
      policy_->begin(keyframe, session_);
    }
    if (!session_.placed()) return may_correct ? findSession() : void();
    policy_->extend(keyframe);
  }
  if (keyframe.refresh && keyframe.session == session_.number() && session_.searchUnderWay() && may_correct)
    return findSession();
  const bool known = session_.placed() && keyframe.session == session_.number() && map_.keyframes.size() > 0;
  if (known && map_.join && map_.join->driveTo(map_.poseOf(keyframe).translation())) {
    first_placed_ = map_.join->first;
    map_.confirmJoin();
  }
  if (may_correct && known) policy_->follow(keyframe);
}

void BackEnd::findSession() {
  const Pose2 T_map_newest = map_.keyframes.pose(map_.newest());
  const auto finding = session_.find(map_, policy_->isMapped(T_map_newest.translation()));
  elsewhere_ = finding.elsewhere;
  if (finding.refuted) reference_.refute(session_.number());
  if (finding.found) {
    place(*finding.found);
    ++placed_;
  } else if (policy_->outgrownBy(session_)) {  // the session, where it is, becomes the map
    std::fill(map_.in_map.begin(), map_.in_map.end(), 0);
    map_.first_in_map = session_.first();
    ++begun_anew_;
    place({T_map_newest, {}});
  }
}

void BackEnd::place(const Relocalisation::Found& found) {
  PoseGraph& graph = map_.keyframes.graph();
  const Pose2 T_map_session = found.T_map_newest * graph.pose(map_.newest()).inverse();
  for (int id = session_.first(); id < graph.size(); ++id) graph.setPose(id, T_map_session * graph.pose(id));
  first_placed_ = session_.first();
  session_.place();
  policy_->place(found, session_);
  reference_.place(T_map_session);
}

bool BackEnd::draws(std::int32_t session) const {
  return session_.placed() && session == session_.number() && policy_->draws();
}

std::vector<MapScan> BackEnd::mapScans(const Keyframe& keyframe) const {
  std::vector<MapScan> scans;
  if (!draws(keyframe.session)) return scans;
  if (keyframe.refresh) scans.push_back({-1, map_.poseOf(keyframe), std::make_shared<const StoredScan>(keyframe)});
  for (int id = cleared_ ? map_.given : first_placed_; id < map_.keyframes.size(); ++id) {
    if (id < first_placed_ && !map_.inMap(id)) continue;
    scans.push_back({id, map_.keyframes.pose(id), map_.keyframes.scan(id)});
  }
  return scans;
}

std::optional<MapView> BackEnd::mapView(const DepthObservation& sight) const {
  const bool known = sight.keyframe >= 0 && sight.keyframe < map_.keyframes.size() && map_.inMap(sight.keyframe);
  if (!known || !draws(sight.session)) return std::nullopt;
  return MapView{sight.keyframe, map_.keyframes.pose(sight.keyframe), sight.T_keyframe_base,
                 std::make_shared<const DepthView>(sight.laser, T_base_depth_), map_.edits.made};
}

BackEndCounters BackEnd::counters() const {
  BackEndCounters counters;
  counters.keyframes = keyframes_;
  counters.placed = placed_;
  counters.begun_anew = begun_anew_;
  counters.corrections = reference_.made();
  session_.addTo(counters);
  policy_->addTo(counters);
  return counters;
}

}  // namespace slam
