// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <memory>
#include <unordered_map>
#include <vector>

#include "slam/map_state.hpp"

namespace slam {

/// Depth views that the last checkpoint of the map does not hold. The journal behind it may hold the first of them.
class UnstoredViews {
 public:
  /// For another map.
  void clear() { *this = UnstoredViews(); }
  /// Takes a few of each keyframe, so that a known place writes no more.
  void add(const MapView& view);
  std::size_t size() const { return views_.size(); }
  int added() const { return added_; }  ///< since clear()

  /// Those that the journal does not hold either; a copy for the disk's thread, since new ones come while it writes.
  std::shared_ptr<const std::vector<MapView>> unjournalled() const;
  /// The journal holds the first so many ...
  void setJournalled(std::size_t count) { journalled_ = count; }
  /// ... or a checkpoint does.
  void setCheckpointed(std::size_t count);

 private:
  std::vector<MapView> views_;
  std::size_t journalled_ = 0;
  std::unordered_map<int, int> of_keyframe_;  // taken
  int added_ = 0;
};

}  // namespace slam
