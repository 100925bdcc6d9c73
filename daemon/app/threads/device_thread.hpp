// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <optional>
#include <utility>

#include "drivers/retry.hpp"
#include "runtime/realtime.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Waits longer from attempt to attempt.
class BackOff {
 public:
  void reset() { retry_.succeeded(); }
  /// @param enough is asked every few milliseconds: true ends the wait
  void wait(const std::function<bool()>& enough);

 private:
  Retry retry_{std::chrono::milliseconds(100)};
};

/// Thread that owns a device which is waited for (lidar, depth camera): connects, reads, and when the connection is
/// over connects again with back-off. What is read goes into the driver's sink.
template <typename Driver>
class DeviceThread {
 public:
  /// @param arguments of the driver's constructor
  template <typename... Arguments>
  DeviceThread(const WorkerConfig& config, Arguments&&... arguments)
      : driver_(std::forward<Arguments>(arguments)...), priority_(config.priority), worker_(config, [this] { run(); }) {
    if constexpr (requires { driver_.setLossHandler(std::function<void()>()); })
      driver_.setLossHandler([this] { ending_.emplace(priority_); });
  }
  ~DeviceThread() {
    worker_.stop();
    driver_.stop();
  }

  Worker& worker() { return worker_; }
  Driver& driver() { return driver_; }

 private:
  static constexpr Duration kPollTimeout = std::chrono::milliseconds(100);  // the longest wait for a request to stop

  void run() {
    if (connected_) {
      connected_ = driver_.poll(kPollTimeout);
      ending_.reset();
      return;
    }
    const NormalPriority connecting(priority_);  // which allocates, opens files and begins threads
    connected_ = driver_.connect(worker_.stopping());
    if (connected_) return back_off_.reset();
    back_off_.wait([this] {
      if constexpr (requires { driver_.returned(); }) {
        if (driver_.returned()) return true;
      }
      return worker_.stopping().load();
    });
  }

  Driver driver_;
  int priority_;
  bool connected_ = false;
  std::optional<NormalPriority> ending_;  // a connection is
  BackOff back_off_;
  Worker worker_;
};

}  // namespace slam
