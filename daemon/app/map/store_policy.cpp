// SPDX-License-Identifier: BSD-3-Clause
#include "app/map/store_policy.hpp"

#include <cmath>
#include <utility>

#include "mapping/mapper.hpp"

namespace slam {
namespace {

constexpr double kPoseMoved = 0.1;  // [m, rad] a pose that differs less is not written again

}  // namespace

void UnstoredViews::add(const MapView& view) {
  if (++of_keyframe_[view.keyframe] > static_cast<int>(ViewMemoryConfig{}.per_keyframe)) return;
  views_.push_back(view);
  ++added_;
}

std::shared_ptr<const std::vector<MapView>> UnstoredViews::unjournalled() const {
  return std::make_shared<const std::vector<MapView>>(views_.begin() + static_cast<std::ptrdiff_t>(journalled_),
                                                      views_.end());
}

void UnstoredViews::setCheckpointed(std::size_t count) {
  views_.erase(views_.begin(), views_.begin() + static_cast<std::ptrdiff_t>(count));
  journalled_ = 0;
}

void StorePolicy::beginMap(bool written) {
  written_ = written;
  required_ = false;
  views_.clear();
}

StorePolicy::Due StorePolicy::due(Timestamp now, std::int64_t changes, const Pose2& T_map_base,
                                  bool has_journal) const {
  const bool outdated = toSeconds(now - checkpoint_begun_) >= config_.checkpoint_period;
  if (required_ || !has_journal || (outdated && changes != checkpointed_.changes)) return Due::kCheckpoint;
  if (toSeconds(now - journal_begun_) < config_.journal_period) return Due::kNothing;
  const Pose2 moved = between(journalled_.T_map_base, T_map_base);
  const bool stays = std::hypot(moved.x, moved.y) <= kPoseMoved && std::abs(moved.theta) <= kPoseMoved;
  return stays && changes == journalled_.changes ? Due::kNothing : Due::kJournal;
}

StorePolicy::Extent StorePolicy::beginAttempt(std::int64_t changes, const Pose2& T_map_base) {
  return {changes, views_.size(), std::exchange(required_, false), T_map_base};
}

void StorePolicy::endAttempt(Due attempt, const Extent& extent, Timestamp begun, bool written) {
  const bool checkpoint = attempt == Due::kCheckpoint;
  (checkpoint ? checkpoint_begun_ : journal_begun_) = begun;
  if (!written) return cancelAttempt(extent);
  journalled_ = extent;
  if (checkpoint) checkpointed_ = extent;
  checkpoint ? views_.setCheckpointed(extent.views) : views_.setJournalled(extent.views);
}

}  // namespace slam
