// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <utility>

#include "drivers/retry.hpp"
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
      : driver_(std::forward<Arguments>(arguments)...), worker_(config, [this] { run(); }) {}
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
      return;
    }
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
  bool connected_ = false;
  BackOff back_off_;
  Worker worker_;
};

}  // namespace slam
