// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "app/config.hpp"
#include "app/exchange.hpp"
#include "runtime/clock.hpp"
#include "runtime/worker.hpp"
#include "slam/mapper.hpp"

namespace slam {

/// Thread *mapper*: draws keyframes and sends the tiles that changed.
class MapperThread {
 public:
  MapperThread(const Config& config, Exchange& exchange, const WallClock& clock);
  Worker& worker() { return worker_; }

  /// For after the thread has stopped: draws what is left in the queue and writes the map files, if any are configured.
  /// @return false when they could not be written
  bool finish();
  /// For after the thread has stopped, too.
  DrawnMap drawn() const { return {mapper_.grid().clone(), mapper_.views()}; }

 private:
  void tick();
  void draw(const MapChange& change);
  void sendTiles();
  bool save();

  const Config& config_;
  Exchange& exchange_;
  const WallClock& clock_;
  Mapper mapper_;
  std::vector<TileIndex> unsent_, to_refresh_;  // changed; to be sent again in their turn
  std::int32_t map_id_ = 0;
  std::int64_t utime_ = 0;  // of the newest keyframe
  bool meta_due_ = false;
  Worker worker_;
};

}  // namespace slam
