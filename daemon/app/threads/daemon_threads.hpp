// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <vector>

#include "app/channels.hpp"
#include "app/devices.hpp"
#include "app/threads/base_thread.hpp"
#include "app/threads/bus_thread.hpp"
#include "app/threads/estimator_thread.hpp"
#include "app/threads/graph_thread.hpp"
#include "app/threads/mapper_thread.hpp"
#include "app/threads/pose_thread.hpp"
#include "app/threads/thread_watchdog.hpp"
#include "config/config.hpp"

namespace slam {

/// The daemon's threads beside that of the supervisor: made in the order in which they need each other, watched, and
/// ended in order, the wheels first.
class DaemonThreads {
 public:
  /// The base's runs from here on. @param look between two looks of the watchdog
  /// @throws std::system_error when the system has no thread or descriptor left
  DaemonThreads(const Config& config, Channels& channels, WallClock& clock, Duration look);

  /// Starts all others.
  void start();
  void stopWheels() {
    if (base_) base_->stop();
  }
  /// Ends all, and stores what they have. @return false: the map was not saved
  bool stop();
  /// A thread waits for a disk, or has never ended its turn: it cannot be joined.
  bool hang() { return graph_.jobs().isWriting() || mapper_.isWriting() || hangs_; }

  BaseThread* base() const { return base_.get(); }     ///< nullptr: not wanted
  LidarThread* lidar() const { return lidar_.get(); }  ///< the same
  DepthThread* depth() const { return depth_.get(); }  ///< the same
  GraphThread& graph() { return graph_; }
  const GraphThread& graph() const { return graph_; }
  MapperThread& mapper() { return mapper_; }
  BusThread& bus() { return bus_; }
  const BusThread& bus() const { return bus_; }
  ThreadWatchdog& watchdog() { return watchdog_; }
  const ThreadWatchdog& watchdog() const { return watchdog_; }
  std::vector<Recorder*> recorders() const;  ///< of output.record and the field log, where there are some

 private:
  void watchThreads();
  bool end(Worker& worker, Timestamp deadline);

  std::unique_ptr<BaseThread> base_;
  std::unique_ptr<LidarThread> lidar_;
  std::unique_ptr<DepthThread> depth_;
  GraphThread graph_;  // before the estimator: it loads the map
  EstimatorThread estimator_;
  MapperThread mapper_;
  BusThread bus_;
  PoseThread pose_;
  ThreadWatchdog watchdog_;
  bool hangs_ = false;  // a recorder or a thread
};

}  // namespace slam
