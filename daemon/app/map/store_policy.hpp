// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "config/config.hpp"
#include "core/timestamp.hpp"
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

/// Decides when the map is written, and what of it: what is new goes into the journal, every journal_period; the whole
/// map into a checkpoint, every checkpoint_period, and at once where no journal can hold what has happened.
class StorePolicy {
 public:
  enum class Due : std::uint8_t { kNothing, kJournal, kCheckpoint };
  /// What is written by an attempt.
  struct Extent {
    std::int64_t changes = 0;  ///< of the map, counted up
    std::size_t views = 0;     ///< of views()
    bool required = false;     ///< no journal can hold it
    Pose2 T_map_base = {};
  };

  explicit StorePolicy(const StoreConfig& config) : config_(config) {}
  /// Another map. @param written false: never
  void beginMap(bool written);
  void add(const MapView& view) { written_ ? views_.add(view) : void(); }
  /// For what no journal can hold.
  void requireCheckpoint() { required_ = written_; }
  bool requiresCheckpoint() const { return required_; }
  const UnstoredViews& views() const { return views_; }

  /// @param has_journal that can go on: without one there is no checkpoint either
  Due due(Timestamp now, std::int64_t changes, const Pose2& T_map_base, bool has_journal) const;
  /// What an attempt writes that begins with the map as it is now. A checkpoint that is required is no more ...
  Extent beginAttempt(std::int64_t changes, const Pose2& T_map_base);
  /// ... unless the attempt comes to nothing.
  void cancelAttempt(const Extent& extent) { required_ |= extent.required; }
  /// An attempt has ended. @param begun when it began to write
  void endAttempt(Due attempt, const Extent& extent, Timestamp begun, bool written);

 private:
  const StoreConfig& config_;
  bool written_ = false, required_ = false;
  Timestamp checkpoint_begun_{}, journal_begun_{};
  Extent checkpointed_, journalled_;  // last
  UnstoredViews views_;
};

}  // namespace slam
