// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <csignal>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/channels.hpp"
#include "app/counters.hpp"
#include "app/device_monitor.hpp"
#include "app/devices.hpp"
#include "app/health_reporter.hpp"
#include "app/log/storage_watch.hpp"
#include "app/log/trouble_log.hpp"
#include "app/threads/base_thread.hpp"
#include "app/threads/bus_thread.hpp"
#include "app/threads/estimator_thread.hpp"
#include "app/threads/graph_thread.hpp"
#include "app/threads/mapper_thread.hpp"
#include "app/threads/pose_thread.hpp"
#include "app/threads/thread_watchdog.hpp"
#include "config/config.hpp"

namespace slam {

/// Owns all threads of the daemon, and who looks after them. Logs what the real-time threads may not, and stops all on
/// SIGINT, SIGTERM or SIGHUP, the wheels first.
class Supervisor {
 public:
  /// @throws std::system_error when the system has no thread or descriptor left
  explicit Supervisor(const Config& config);
  ~Supervisor();

  /// Those that end slamd in order. SIGHUP only where it is not ignored already, as by nohup.
  static sigset_t stopSignals();
  /// Runs until one of them. The calling thread must have them blocked. @return exit code
  int run();

 private:
  void watchDevices();
  void watchThreads();
  void start();
  void logClaimants() const;  ///< names that udev may give to the wrong device
  bool end(Worker& worker, Timestamp deadline);
  bool stop();  ///< false: the map was not saved
  std::vector<Trouble> poseTroubles(Timestamp now);
  std::vector<Trouble> otherTroubles(Timestamp now) const;
  void log(const std::vector<Trouble>& others, Timestamp now);
  void followClock(Timestamp now);
  std::vector<Trouble> withThreads(std::vector<Trouble> troubles, Timestamp now) const;
  Counted counted();

  const Config config_;
  WallClock clock_;
  Channels channels_;
  std::unique_ptr<BaseThread> base_;
  std::unique_ptr<LidarThread> lidar_;
  std::unique_ptr<DepthThread> depth_;
  GraphThread graph_;  // before the estimator: it loads the map
  EstimatorThread estimator_;
  MapperThread mapper_;
  BusThread bus_;
  PoseThread pose_;
  DeviceMonitor devices_;
  ThreadWatchdog watchdog_;
  StorageWatch storage_;
  HealthReporter health_;
  Problem not_locked_;  // memory
  PoseSnapshot snapshot_;
  BackEndCounters graph_counters_;
  CanLinkCounters can_counters_;
  TroubleLog log_;
  bool recorder_hangs_ = false, thread_hangs_ = false, localised_ = false, link_worked_ = false;
  std::optional<Timestamp> unlocalised_since_;
  LinkState link_seen_ = LinkState::kOpening;
};

}  // namespace slam
