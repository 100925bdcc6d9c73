// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/channels.hpp"
#include "app/log/storage_report.hpp"
#include "app/map/graph_work.hpp"
#include "app/map/map_commands.hpp"
#include "app/map/map_keeper.hpp"
#include "app/map/store_policy.hpp"
#include "config/config.hpp"
#include "runtime/job_thread.hpp"

namespace slam {

/// Has the map loaded and stored by a thread of its own, *map*, one job at a time: while the disk hangs, what is new
/// waits for the next job. Belongs to the graph thread.
class MapJobs {
 public:
  /// Begins in the stored map, if the disk gives it in time; else changes to it when it does.
  MapJobs(const Config& config, const GraphEnds& ends, GraphWork& work, StorePolicy& policy);

  /// Takes commands, and begins the next job when one is due.
  void tick();

  /// For after the thread has stopped: begins to store the map with the grid as the mapper left it.
  void store(DrawnMap drawn);
  /// @return false when it has not been stored by the deadline: isWriting() says whether it still is being written
  bool waitUntilStored(Timestamp deadline);
  bool isWriting() const { return disk_.isBusy(); }
  /// What is not stored and why, when waitUntilStored() has been in vain.
  std::string loss() const;

  /// The maps of which the robot may be in any. From any thread.
  Problem floorDoubt() const { return work_.floorDoubt(); }
  StorageReport report(Timestamp now) const { return {keeper_.problem(), {}, disk_.blockedFor(now)}; }

 private:
  bool hangs() const;
  void beginIn(MapState map);
  /// @param T_next_base where the robot is in it; none: it has to be found there
  void changeTo(MapState next, const std::optional<Pose2>& T_next_base = std::nullopt);
  std::optional<Pose2> poseAfter(const MapCommands::Command& command) const;
  void beginDue(Timestamp now);
  void requestGrid();
  void writeCheckpoint(DrawnMap drawn);
  void writeJournal(Timestamp now);
  void retry(Timestamp now);
  /// @param job for the disk's thread @param then for this one, at the first tick behind its end
  void start(std::function<void()> job, std::function<void()> then);
  bool diskIsFree();

  const Config& config_;
  const GraphEnds& ends_;
  GraphWork& work_;
  StorePolicy& policy_;
  MapKeeper keeper_;
  MapCommands commands_{keeper_, work_, ends_.answers};
  /// What the grid that was asked for from the mapper shows.
  struct Requested {
    int keyframes = 0, generation = 0;
    StorePolicy::Extent extent;
  };
  std::optional<Requested> requested_;  // only while the disk is free, and no job begins before the grid is here
  std::function<void()> then_;          // behind the job under way
  std::shared_ptr<const bool> stored_;  // by the last job of all
  JobThread disk_{"map"};               // keeper_ is its own while it is busy
};

}  // namespace slam
