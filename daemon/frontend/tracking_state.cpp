// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/tracking_state.hpp"

#include <algorithm>
#include <cmath>

namespace slam {

TrackingState::TrackingState(const TrackingConfig& config, bool localise_only, bool in_known_map)
    : config_(config), localise_only_(localise_only), place_(in_known_map ? Place::kNever : Place::kKnown) {}

void TrackingState::begin(Timestamp stamp, const Pose2& T_map_base, const Pose2& T_odom_base) {
  last_match_ = stamp;
  last_pose_ = T_map_base;
  last_motion_ = {};
  last_odometry_ = T_odom_base;
}

void TrackingState::follow(const MatchResult& match, Timestamp stamp, const Pose2& T_map_base,
                           const Pose2& T_odom_base) {
  ++(match.observable == 3 ? matched_ : partly_observable_);
  overlap_ = fused_overlap_ = match.overlap;
  tension_ = match.tension;
  failures_ = 0;
  last_match_ = stamp;
  last_motion_ = between(last_pose_, T_map_base);
  last_pose_ = T_map_base;
  last_odometry_ = T_odom_base;
}

bool TrackingState::fail(const MatchResult& match, Timestamp stamp, bool informative, bool may_act) {
  ++(match.usable() ? gated_ : unmatched_);
  overlap_ = match.overlap;
  if (!informative) return false;
  const bool lately = toSeconds(stamp - *last_match_) < config_.degraded_after;  // a fast lidar fails often
  if (++failures_ <= config_.max_failures || lately || !may_act) return false;
  failures_ = 0;
  return true;
}

bool TrackingState::lost(const Eigen::Matrix3d& covariance) const {
  return localise_only_ || !placed() || unplaced(covariance);
}

bool TrackingState::unplaced(const Eigen::Matrix3d& covariance) const {
  return std::sqrt(std::max(covariance(0, 0), covariance(1, 1))) > config_.lost_position_sigma;
}

void TrackingState::beginSession(Place place) {
  if (place != Place::kNoMore || place_ != Place::kNever) place_ = place;
  tension_.setZero();
  failures_ = 0;
}

LocalisationState TrackingState::state(Timestamp stamp, Timestamp last_source, const Eigen::Matrix3d& covariance,
                                       bool contradicted) const {
  if (!last_match_) return LocalisationState::kInitialising;
  if (place_ == Place::kNever) return LocalisationState::kInitialising;
  if (place_ == Place::kNoMore) return LocalisationState::kLost;
  if (unplaced(covariance) || silent(stamp, last_source)) return LocalisationState::kLost;
  return unmatched(stamp) || failures_ > 0 || contradicted || assumed() ? LocalisationState::kDegraded
                                                                        : LocalisationState::kLocalised;
}

bool TrackingState::unmatched(Timestamp stamp) const {
  return last_match_ && toSeconds(stamp - *last_match_) > config_.degraded_after;
}

void TrackingState::addTo(FrontEndCounters& counters) const {
  counters.matched = matched_;
  counters.partly_observable = partly_observable_;
  counters.unmatched = unmatched_;
  counters.gated = gated_;
}

}  // namespace slam
