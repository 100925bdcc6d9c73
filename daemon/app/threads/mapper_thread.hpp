// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <string>
#include <vector>

#include "app/channels.hpp"
#include "app/log/storage_report.hpp"
#include "config/config.hpp"
#include "drivers/retry.hpp"
#include "mapping/mapper.hpp"
#include "runtime/clock.hpp"
#include "runtime/job_thread.hpp"
#include "runtime/shared_value.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Thread *mapper*: draws keyframes and sends the tiles that changed. Has map files written by a thread of its own,
/// *map files*.
class MapperThread {
 public:
  MapperThread(const Config& config, const MapperEnds& ends, const WallClock& clock);
  Worker& worker() { return worker_; }

  /// For after the thread has stopped: draws what is left in the queue and begins to write the map files, if any are
  /// configured.
  void finish();
  /// @return false when they have not been written by the deadline: isWriting() says whether they still are being
  /// written
  bool waitUntilSaved(Timestamp deadline);
  bool isWriting() const { return disk_.isBusy(); }

  StorageReport storage(Timestamp now) const { return {{problem_.get()}, {}, disk_.blockedFor(now)}; }
  /// For after the thread has stopped, too.
  DrawnMap drawn() const { return {mapper_.grid().clone(), mapper_.views()}; }

 private:
  void tick();
  void draw(const MapChange& change);
  void sendTiles();
  void sendLayers();
  void save();
  void checkFolder(Timestamp now);

  const Config& config_;
  const MapperEnds ends_;
  const WallClock& clock_;
  Mapper mapper_;
  std::vector<TileIndex> unsent_, to_refresh_;  // changed; to be sent again in their turn
  std::vector<TileIndex> unsent_layers_;        // of tiles that were sent
  std::int32_t map_id_ = 0;
  std::int64_t utime_ = 0;  // of the newest keyframe
  bool meta_due_ = false;
  SharedValue<Problem> problem_;                                    // with the map files
  std::atomic<bool> folder_known_{false};                           // to be there
  Retry retry_{std::chrono::seconds(1), std::chrono::seconds(10)};  // to look at the folder
  JobThread disk_{"map files"};
  Worker worker_;
};

}  // namespace slam
