// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <pthread.h>
#include <string>

#include "core/timestamp.hpp"
#include "runtime/latency_histogram.hpp"
#include "runtime/thread_use.hpp"
#include "runtime/wakeup.hpp"

namespace slam {

struct WorkerConfig {
  std::string name;
  double rate = 0.0;  ///< [Hz] fixed rate; 0: the body waits by itself and is called again at once
  int priority = 0;   ///< SCHED_FIFO; 0: normal scheduling
};

/// The end of a thread, for which another one waits no longer than it wants to.
class EndSignal {
 public:
  void reset() { ended_ = false; }
  void set() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();  // within the lock: who waits may destroy it
  }
  /// @return whether it has come
  bool waitFor(Duration time) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, time, [this] { return ended_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
};

/// A thread that calls its body until it is told to stop: at a fixed rate by absolute deadlines, or as often as the
/// body returns. A tick that ends after the next one's deadline is an overrun; the deadlines it missed are skipped, not
/// caught up, so that a hiccup does not become a burst.
class Worker {
 public:
  Worker(const WorkerConfig& config, std::function<void()> body);
  /// With a fixed rate whose waits a wake-up interrupts. The deadlines stay, and only they count as ticks.
  /// @param woken is called for each wake-up, or once for several
  Worker(const WorkerConfig& config, std::function<void()> body, Wakeup& wakeup, std::function<void()> woken);
  ~Worker() { stop(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Starts the thread. @throws std::system_error when it cannot be made
  void start();
  /// Asks the thread to end and joins it.
  void stop();
  /// The same, but waits no longer than until `deadline`. @return whether it has ended
  bool stop(Timestamp deadline);
  void requestStop() { stopping_ = true; }
  const std::atomic<bool>& stopping() const { return stopping_; }

  const std::string& name() const { return config_.name; }
  double rate() const { return config_.rate; }
  std::uint64_t ticks() const { return ticks_.load(std::memory_order_acquire); }
  std::uint64_t overruns() const { return overruns_.load(std::memory_order_relaxed); }
  /// How late ticks began; empty without a fixed rate.
  const LatencyHistogram& lateness() const { return lateness_; }
  const LatencyHistogram& duration() const { return duration_; }
  /// By how much the latest tick since the last call began too late, behind a slow tick or a late wake-up; 0 without a
  /// fixed rate. For one reader.
  Duration takeWorstDelay() { return Duration(worst_delay_ns_.exchange(0, std::memory_order_relaxed)); }
  /// [s] of CPU that the thread has used, while it runs; 0 before and after.
  double cpuSeconds() const;
  /// What the thread has had of the CPU; std::nullopt: it does not run.
  std::optional<ThreadUse> use() const;
  /// What stood in the way of real-time scheduling; empty: nothing. Valid once the first tick has begun.
  const std::string& warning() const { return warning_; }

 private:
  static void* entry(void* self);
  void run();
  void waitUntil(Timestamp deadline);

  WorkerConfig config_;
  std::function<void()> body_;
  Wakeup* wakeup_ = nullptr;
  std::function<void()> woken_;
  pthread_t thread_{};
  std::atomic<pid_t> id_{0};  // of the thread, once it has begun
  bool running_ = false;
  std::atomic<bool> stopping_{false};
  EndSignal end_;
  std::atomic<std::uint64_t> ticks_{0}, overruns_{0};
  std::atomic<std::int64_t> worst_delay_ns_{0};
  LatencyHistogram lateness_, duration_;
  std::string warning_;
};

}  // namespace slam
