// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <csignal>
#include <vector>

#include "app/channels.hpp"
#include "app/counters.hpp"
#include "app/device_monitor.hpp"
#include "app/health_reporter.hpp"
#include "app/log/storage_watch.hpp"
#include "app/log/trouble_log.hpp"
#include "app/pose_problem.hpp"
#include "app/threads/daemon_threads.hpp"
#include "config/config.hpp"

namespace slam {

/// Looks after the daemon's threads and devices. Logs what the real-time threads may not, and stops all on
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
  void start();
  void logClaimants() const;  ///< names that udev may give to the wrong device
  std::vector<Trouble> otherTroubles(Timestamp now) const;
  void log(const std::vector<Trouble>& others, Timestamp now);
  void followClock(Timestamp now);
  std::vector<Trouble> withThreads(std::vector<Trouble> troubles, Timestamp now) const;
  Counted counted();

  const Config config_;
  WallClock clock_;
  Channels channels_;
  DaemonThreads threads_;
  DeviceMonitor devices_;
  StorageWatch storage_;
  HealthReporter health_;
  Problem not_locked_;  // memory
  PoseSnapshot snapshot_;
  BackEndCounters graph_counters_;
  CanLinkCounters can_counters_;
  TroubleLog log_;
  PoseWatch pose_watch_;
  bool link_worked_ = false;
  LinkState link_seen_ = LinkState::kOpening;
};

}  // namespace slam
