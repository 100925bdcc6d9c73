// SPDX-License-Identifier: BSD-3-Clause
#include "app/unstored_views.hpp"

#include "mapping/mapper.hpp"

namespace slam {

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

}  // namespace slam
