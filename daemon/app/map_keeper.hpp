// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "app/config.hpp"
#include "core/timestamp.hpp"
#include "slam/map_state.hpp"
#include "store/durable_file.hpp"
#include "store/map_store.hpp"

namespace slam {

/// Which map slamd works on, and when it is written. Writes nothing in mode "localise" or without store.directory. A
/// failure to write is logged once until writing works again; nothing else stops for it.
class MapKeeper {
 public:
  explicit MapKeeper(const Config& config) : config_(config) {}

  /// The map to begin with: the one configured, or the newest one, or a new one; what was damaged is logged.
  /// @throws std::runtime_error with one line when mode is "localise" and there is none, or the configured one is of no
  /// use
  MapState begin();
  /// Changes to another map. @throws std::runtime_error with one sentence; then the present one stays
  MapState load(const std::string& name);
  /// Leaves the present map as it is on disk and works on a new one.
  void beginNew();

  bool writes() const { return store_ != nullptr; }
  const std::string& name() const { return name_; }

  /// What is new goes to the journal, every journal_period. @param changes counts up with the map's changes
  bool journalDue(Timestamp now, const Pose2& T_map_base, std::int64_t changes) const;
  /// @param seen by the depth camera since it was written last @return false when it could not be written
  bool journal(Timestamp now, const MapState& map, std::span<const MapView> seen, std::int64_t changes);
  /// Whether a new generation should be written.
  bool checkpointDue(Timestamp now, std::int64_t changes) const;
  /// @param seen as in journal() @return false when it could not be written
  bool checkpoint(Timestamp now, const MapState& map, std::int64_t changes, std::span<const MapView> seen = {});
  /// Writes the map under another name; the present one stays. @throws std::runtime_error
  void saveAs(const std::string& name, const MapState& map) const;

 private:
  MapState open(const std::string& path);
  void keep(const std::string& name);
  std::unique_ptr<FolderLock> lockOf(const std::string& name) const;
  bool attempt(const std::string& what, const std::function<void()>& write);

  const Config& config_;
  std::string name_;
  std::unique_ptr<FolderLock> lock_;  // of the map's folder
  std::unique_ptr<MapStore> store_;
  Timestamp journalled_{}, checkpointed_{};
  std::int64_t journalled_changes_ = -1, checkpointed_changes_ = -1;
  Pose2 journalled_pose_;
  bool failing_ = false;
};

}  // namespace slam
