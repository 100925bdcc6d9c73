// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "app/log/trouble_log.hpp"
#include "drivers/device_status.hpp"
#include "runtime/watchdog.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Looks after the daemon's threads: feeds systemd's watchdog only while every vital one is alive, and logs which one
/// is dead, was late, or has no real-time scheduling.
class ThreadWatchdog {
 public:
  /// @param period at which it is looked at them
  explicit ThreadWatchdog(Duration period) : watchdog_(period) {}

  /// @param connects the thread is silent for long while this device is not streaming
  void add(Worker& worker, const SilenceLimits& limits, const DeviceStatus* connects = nullptr);
  void look(Timestamp now);
  /// As of Watchdog.
  bool isOverloaded(Timestamp now) const { return watchdog_.isOverloaded(now); }
  std::vector<Problem> problems(Timestamp now) const { return watchdog_.problems(now); }
  const std::vector<Worker*>& workers() const { return workers_; }

 private:
  std::vector<Worker*> workers_;
  std::vector<const DeviceStatus*> connects_;   // of each of these, or nullptr
  std::vector<bool> warned_;                    // the same: about its scheduling
  std::vector<std::optional<ThreadUse>> uses_;  // of each at the last look ...
  std::optional<Timestamp> looked_;             // ... which was then
  Watchdog watchdog_;
  TroubleLog log_;
};

}  // namespace slam
