// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <ctime>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "app/log/storage_report.hpp"
#include "config/config.hpp"
#include "core/timestamp.hpp"
#include "drivers/retry.hpp"
#include "runtime/shared_value.hpp"
#include "slam/map_state.hpp"
#include "store/durable_file.hpp"
#include "store/map_store.hpp"

namespace slam {

/// Which map slamd works on, and how it is written. Writes nothing in mode "localise" or without store.directory.
///
/// A disk ends nothing: a map that cannot be used, and one that cannot be written, are a problem() and are
/// tried again, and so is a folder that somebody removed. One thread at a time; problem() from any.
class MapKeeper {
 public:
  explicit MapKeeper(const Config& config) : config_(config), localises_(config.mode == RunMode::kLocalise) {}

  /// What no disk can heal, for who starts slamd: it is told what to write into which key. Empty: nothing.
  static std::string misconfiguration(const Config& config);

  /// The map to begin with: the one configured, or the newest one, or a new one. Where the configured one cannot be
  /// used, it is one without keyframes, which is not written; retry() looks again.
  MapState begin(Timestamp now);
  /// Something has failed that retry() may bring to its end.
  bool waitsForDisk() const { return awaits_ || (writes() && !store_); }
  /// Whether it should be tried again by now.
  bool retryDue(Timestamp now) const { return waitsForDisk() && retry_.due(now); }
  /// @return the map that was configured, where it could not be used before and can be now
  std::optional<MapState> retry(Timestamp now);
  /// Changes to another map. @throws std::runtime_error with one sentence; then the present one stays
  MapState load(const std::string& name, Timestamp now);
  /// Goes on in the stored map: to localise in it as it is, or to extend it; where there is none yet, a new one begins.
  /// @throws std::runtime_error with one sentence; then the present mode stays
  MapState changeMode(bool localise, Timestamp now);
  /// Leaves the present map as it is on disk and works on a new one.
  void beginNew(Timestamp now);

  /// Whether the map stays as it is: from the start by the configuration, then as changed last. From any thread.
  bool localises() const { return localises_; }
  /// Whether the map is to be written. From any thread.
  bool writes() const { return !localises_ && !config_.store.directory.empty(); }
  const std::string& name() const { return name_; }
  const std::string& directory() const { return config_.store.directory; }  ///< of all maps; empty: none are stored
  /// The one that slamd begins with; empty: the newest.
  const std::string& configuredName() const { return config_.store.map; }
  const OccupancyGridConfig& gridConfig() const { return config_.map; }
  /// Keyframes of the present map that are on the disk. From any thread.
  int stored() const { return stored_; }
  /// What is not read or written and why, what slamd does meanwhile, and the fix; empty: nothing.
  StorageProblem problem() const { return problem_.get(); }

  /// Whether one of these two may be tried: now, not long behind a failure.
  bool mayWrite(Timestamp now) const { return store_ && retry_.due(now); }
  /// Whether there is a journal that can go on.
  bool hasJournal() const { return store_ && has_journal_; }
  /// Appends what is new. @param seen by the depth camera since it was written last
  /// @return false when it could not be written
  bool journal(Timestamp now, const MapState& map, std::span<const MapView> seen = {});
  /// Writes a new generation. @param seen as in journal() @return false when it could not be written
  bool checkpoint(Timestamp now, const MapState& map, std::span<const MapView> seen = {});
  /// Writes the map under another name than its own, which checkpoint() writes; the present one stays.
  /// @throws std::runtime_error
  void saveAs(const std::string& name, const MapState& map) const;

 private:
  std::optional<MapState> take(Timestamp now);
  std::string newestMap() const;
  MapState open(const std::string& path);
  void keep(const std::string& name, Timestamp now);
  std::unique_ptr<FolderLock> lockOf(const std::string& name) const;
  bool attempt(Timestamp now, const MapState& map, const std::function<void()>& write);
  StorageProblem notWritten(const std::exception& error) const;
  void fail(Timestamp now, StorageProblem problem);
  void succeed();

  const Config& config_;
  std::atomic<bool> localises_;
  std::string name_;
  bool awaits_ = false;               // the configured map cannot be used yet
  std::unique_ptr<FolderLock> lock_;  // of the map's folder
  std::unique_ptr<MapStore> store_;   // nullptr: not written, or not yet
  bool has_journal_ = false;          // a checkpoint of this slamd, and all behind it is on the disk
  int generation_ = 0;                // newest one on disk when the map was opened, or the disk went
  std::atomic<int> stored_{0};        // keyframes of the map on the disk ...
  int known_ = 0;                     // ... and of all, when it was written or was to be
  std::time_t written_ = 0;           // [s since the epoch] last; 0: not since slamd was started
  std::string leftover_;              // of older generations, as told last
  SharedValue<StorageProblem> problem_;
  Retry retry_{std::chrono::seconds(1), std::chrono::seconds(30)};
};

}  // namespace slam
