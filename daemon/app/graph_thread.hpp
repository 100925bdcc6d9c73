// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>

#include "app/config.hpp"
#include "app/exchange.hpp"
#include "app/map_keeper.hpp"
#include "runtime/clock.hpp"
#include "runtime/worker.hpp"
#include "slam/back_end.hpp"

namespace slam {

/// Thread *graph*: puts keyframes into the pose graph, closes loops, and hands corrections to the estimator and what
/// is to be drawn to the mapper. Loads and stores the map. It may take its time: nobody waits for it.
class GraphThread {
 public:
  /// @throws std::runtime_error when the map to begin with is of no use
  GraphThread(const Config& config, Exchange& exchange, const WallClock& clock);
  ~GraphThread();
  Worker& worker() { return worker_; }

  /// The front end for the map to begin with.
  std::unique_ptr<Localizer> firstLocalizer() const;

  /// For after the thread has stopped: takes what is left in the queue. Call it before the mapper's finish().
  void finish();
  /// Stores the map with the grid as the mapper left it. @return false when it could not be written
  bool store(DrawnMap drawn);

 private:
  void tick();
  void beginIn(MapState map);
  void keepMap();
  void obey(const MapCommand& command);
  void carryOut(const MapCommand& command, const MapState& map);
  void requestGrid();
  std::span<const MapView> unjournalledViews() const;
  /// @param drawn_keyframes so many are in the grid
  MapState mapState(DrawnMap drawn, int drawn_keyframes) const;
  std::int64_t changes() const;
  void takeIn();
  void add(const Keyframe& keyframe);
  void add(const DepthSight& sight);
  void sendChanges();

  const Config& all_config_;
  Exchange& exchange_;
  const WallClock& clock_;
  MapKeeper keeper_;
  Config fitting_;  // to the map: a picture is coarser than the scans
  BackEndConfig config_;
  std::unique_ptr<BackEnd> back_end_;
  LocalizerStart start_;
  std::int32_t map_id_;
  PoseSnapshot snapshot_;
  Pose2 last_pose_;         // the last one that was valid
  double gyro_bias_ = 0.0;  // [rad/s]
  /// What the grid that was asked for from the mapper shows.
  struct Requested {
    int keyframes = 0, generation = 0;
    std::ptrdiff_t views = 0;  // of new_views_
    std::int64_t changes = 0;
  };
  std::optional<Requested> requested_;
  std::vector<MapView> new_views_;           // which the last checkpoint does not show
  std::size_t journalled_views_ = 0;         // of these, in the journal that follows it
  std::unordered_map<int, int> views_kept_;  // by keyframe, so that a known place writes no more
  int views_ = 0;                            // of these
  std::optional<MapCommand> pending_;        // waits for the grid
  int generation_ = 0;
  bool correction_away_ = false;
  std::vector<DepthSight> sights_;
  std::deque<std::shared_ptr<const MapChange>> changes_;  // not yet in the mapper's queue
  Worker worker_;
};

}  // namespace slam
