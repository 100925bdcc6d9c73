// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>

#include "core/timestamp.hpp"
#include "runtime/thread_use.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// A thread for work that may hang, such as writing to a disk. Jobs run one after the other; who hands them over goes
/// on at once. Safe from any thread.
class JobThread {
 public:
  /// @throws std::system_error when the thread cannot be made
  explicit JobThread(const std::string& name);
  /// Waits for all jobs, however long they take: see waitUntilIdle().
  ~JobThread();

  /// @param job must not throw
  void start(std::function<void()> job);
  bool isBusy() const;
  /// How long the job under way has been kept waiting so far, by anything but the CPU; 0 without one.
  Duration blockedFor(Timestamp now) const { return blocked_.until(now); }
  /// @return false when a job is still under way at the deadline
  bool waitUntilIdle(Timestamp deadline) const;

 private:
  void work();

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;  // the first one is under way
  BlockedTime blocked_;                     // the first one
  bool ending_ = false;
  Worker worker_;
};

}  // namespace slam
