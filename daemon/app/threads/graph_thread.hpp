// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "app/channels.hpp"
#include "app/log/storage_report.hpp"
#include "app/log/trouble_log.hpp"
#include "app/map_keeper.hpp"
#include "app/unstored_views.hpp"
#include "config/config.hpp"
#include "frontend/front_end.hpp"
#include "runtime/clock.hpp"
#include "runtime/job_thread.hpp"
#include "runtime/worker.hpp"
#include "slam/map_builder.hpp"
#include "slam/pipeline.hpp"

namespace slam {

/// Thread *graph*: puts keyframes into the pose graph, closes loops, and hands corrections to the estimator and what
/// is to be drawn to the mapper. Has the map loaded and stored by a thread of its own, *map*, one job at a time: while
/// the disk hangs, what is new waits for the next job. It may take its time: nobody waits for it.
class GraphThread {
 public:
  /// Begins in the stored map, if the disk gives it in time; else changes to it when it does.
  GraphThread(const Config& config, const GraphEnds& ends, const WallClock& clock);
  ~GraphThread() { worker_.stop(); }
  Worker& worker() { return worker_; }

  /// The front end for the map to begin with.
  std::unique_ptr<FrontEnd> firstFrontEnd() const;

  /// For after the thread has stopped: takes what is left in the queue. Call it before the mapper's finish().
  void finish();
  /// Begins to store the map with the grid as the mapper left it.
  void store(DrawnMap drawn);
  /// @return false when it has not been stored by the deadline: isWriting() says whether it still is being written
  bool waitUntilStored(Timestamp deadline);
  bool isWriting() const { return disk_.isBusy(); }
  /// What is not stored and why, when waitUntilStored() has been in vain.
  std::string loss() const;

  StorageReport storage(Timestamp now) const { return {keeper_.problem(), {}, disk_.blockedFor(now)}; }

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
  /// @param drawn_keyframes so many are in the grid
  MapState mapState(DrawnMap drawn, int drawn_keyframes) const;
  std::int64_t changes() const;
  void takeIn();
  void add(const Keyframe& keyframe);
  void add(const DepthObservation& sight);
  void sendChanges();

  const Config& all_config_;
  const GraphEnds ends_;
  const WallClock& clock_;
  MapKeeper keeper_;
  FrontEndConfig front_end_config_;  // fitted to the map
  std::unique_ptr<MapBuilder> builder_;
  int placed_before_ = 0, begun_anew_before_ = 0;  // counted in the maps before
  FrontEndStart start_;
  std::int32_t map_id_;
  PoseSnapshot snapshot_;
  std::int64_t seen_scans_ = 0;  // of it, that the search for a lost robot was allowed for
  Pose2 last_pose_;              // the last one that was valid
  double gyro_bias_ = 0.0;       // [rad/s]
  BodyShape body_;               // what moves with the robot
  /// What the grid that was asked for from the mapper shows.
  struct Requested {
    int keyframes = 0, generation = 0;
    std::size_t views = 0;  // of views_
    std::int64_t changes = 0;
    bool wanted = false;  // for what the journal cannot hold
  };
  std::optional<Requested> requested_;  // only while the disk is free, and no job begins before the grid is here
  UnstoredViews views_;
  std::optional<MapCommand> pending_;  // waits for the disk or the grid
  struct Obeyed {
    explicit Obeyed(const MapCommand& wanted) : command(wanted) {}
    MapCommand command;
    std::atomic_flag taken;  // by the disk's thread, which carries it out, or by this one, which refuses it
  };
  std::shared_ptr<Obeyed> obeyed_;         // whose checkpoint is under way
  bool checkpoint_wanted_ = false;         // the journal cannot hold what has happened
  bool without_map_ = false;               // to localise in
  std::shared_ptr<const Outcome> stored_;  // by the last job of all
  std::vector<DepthObservation> sights_;
  std::deque<std::shared_ptr<const MapChange>> changes_;  // not yet in the mapper's queue
  std::function<void()> then_;                            // behind the job under way
  TroubleLog log_;
  JobThread disk_{"map"};  // keeper_ is its own while it is busy
  Worker worker_;
};

}  // namespace slam
