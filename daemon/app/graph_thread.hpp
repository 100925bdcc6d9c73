// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "app/config.hpp"
#include "app/exchange.hpp"
#include "app/map_keeper.hpp"
#include "app/storage_report.hpp"
#include "runtime/clock.hpp"
#include "runtime/job_thread.hpp"
#include "runtime/worker.hpp"
#include "slam/back_end.hpp"

namespace slam {

/// Thread *graph*: puts keyframes into the pose graph, closes loops, and hands corrections to the estimator and what
/// is to be drawn to the mapper. Has the map loaded and stored by a thread of its own, *map*, one job at a time: while
/// the disk hangs, what is new waits for the next job. It may take its time: nobody waits for it.
class GraphThread {
 public:
  /// Begins in the stored map, if the disk gives it in time; else changes to it when it does.
  GraphThread(const Config& config, Exchange& exchange, const WallClock& clock);
  ~GraphThread();
  Worker& worker() { return worker_; }

  /// The front end for the map to begin with.
  std::unique_ptr<Localizer> firstLocalizer() const;

  /// For after the thread has stopped: takes what is left in the queue. Call it before the mapper's finish().
  void finish();
  /// Begins to store the map with the grid as the mapper left it.
  void store(DrawnMap drawn);
  /// @return false when it has not been stored by the deadline: isWriting() says whether it still is being written
  bool waitUntilStored(Timestamp deadline);
  bool isWriting() const { return disk_.isBusy(); }

  StorageReport storage(Timestamp now) const { return {keeper_.problem(), disk_.busyFor(now)}; }

 private:
  void tick();
  void beginIn(MapState map);
  void keepMap();
  void write(DrawnMap drawn);
  void writeJournal(Timestamp now);
  void lookForMap(Timestamp now);
  void obey(const MapCommand& command);
  void refuse(const MapCommand& command, const std::string& problem);
  /// What a job of the disk has come to.
  struct Outcome {
    bool saved = false;
    std::optional<MapAnswer> answer;
    std::optional<MapState> next;  // to change to
  };
  void carryOut(const MapCommand& command, const MapState& map, Outcome& outcome);
  void changeTo(MapState next);
  /// @param job for the disk's thread @param then for this one, at the first tick behind its end
  void start(std::function<void()> job, std::function<void()> then);
  bool diskIsFree();
  void requestGrid();
  /// A copy for the disk's thread, since new ones come while it writes.
  std::shared_ptr<const std::vector<MapView>> unjournalledViews() const;
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
    bool wanted = false;  // for what the journal cannot hold
  };
  std::optional<Requested> requested_;       // only while the disk is free, and no job begins before the grid is here
  std::vector<MapView> new_views_;           // which the last checkpoint does not show
  std::size_t journalled_views_ = 0;         // of these, in the journal that follows it
  std::unordered_map<int, int> views_kept_;  // by keyframe, so that a known place writes no more
  int views_ = 0;                            // of these
  std::optional<MapCommand> pending_;        // waits for the disk or the grid
  bool obeys_ = false;                       // the job under way carries one out
  bool checkpoint_wanted_ = false;           // the journal cannot hold what has happened
  bool without_map_ = false;                 // to localise in
  std::shared_ptr<const Outcome> stored_;    // by the last job of all
  int generation_ = 0;
  bool correction_away_ = false;
  std::vector<DepthSight> sights_;
  std::deque<std::shared_ptr<const MapChange>> changes_;  // not yet in the mapper's queue
  std::function<void()> then_;                            // behind the job under way
  JobThread disk_{"map"};                                 // keeper_ is its own while it is busy
  Worker worker_;
};

}  // namespace slam
