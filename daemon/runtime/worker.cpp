// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/worker.hpp"

#include <csignal>
#include <cstring>
#include <ctime>
#include <poll.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "runtime/clock.hpp"
#include "runtime/realtime.hpp"

namespace slam {
namespace {

/// Locked memory is there once it was used: half of what is left of the stack, before a deadline waits for it. The
/// thread-local variables lie in the stack, and those of a sanitizer fill most of it.
[[gnu::noinline]] void useStack() {
  pthread_attr_t attributes;
  if (pthread_getattr_np(pthread_self(), &attributes) != 0) return;
  void* lowest = nullptr;
  std::size_t size = 0;
  pthread_attr_getstack(&attributes, &lowest, &size);
  pthread_attr_destroy(&attributes);
  const auto left = static_cast<char*>(__builtin_frame_address(0)) - static_cast<char*>(lowest);
  const auto half = static_cast<std::size_t>(left) / 2;
  explicit_bzero(__builtin_alloca(half), half);
}

timespec timespecOf(Duration time) {
  return {static_cast<time_t>(time.count() / 1000000000), static_cast<long>(time.count() % 1000000000)};
}

void sleepUntil(Timestamp deadline) {
  const timespec t = timespecOf(deadline.time_since_epoch());
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

}  // namespace

Worker::Worker(const WorkerConfig& config, std::function<void()> body) : config_(config), body_(std::move(body)) {}

Worker::Worker(const WorkerConfig& config, std::function<void()> body, Wakeup& wakeup, std::function<void()> woken)
    : config_(config), body_(std::move(body)), wakeup_(&wakeup), woken_(std::move(woken)) {}

void Worker::start() {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kThreadStack);
  end_.reset();
  // Signals belong to the supervisor.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const int error = pthread_create(&thread_, &attributes, &Worker::entry, this);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_attr_destroy(&attributes);
  if (error != 0) throw std::system_error(error, std::generic_category(), "thread " + config_.name);
  running_ = true;
}

void Worker::stop() {
  stopping_ = true;
  if (!running_) return;
  pthread_join(thread_, nullptr);
  running_ = false;
}

bool Worker::stop(Timestamp deadline) {
  stopping_ = true;
  if (running_ && !end_.waitFor(deadline - monotonicNow())) return false;
  stop();
  return true;
}

double Worker::cpuSeconds() const {
  clockid_t clock{};
  timespec used{};
  if (!running_ || pthread_getcpuclockid(thread_, &clock) != 0 || clock_gettime(clock, &used) != 0) return 0.0;
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

std::optional<ThreadUse> Worker::use() const {
  const pid_t id = id_;
  return running_ && id != 0 ? threadUse(id) : std::nullopt;
}

void* Worker::entry(void* self) {
  auto& worker = *static_cast<Worker*>(self);
  worker.run();
  worker.end_.set();
  return nullptr;
}

void Worker::run() {
  id_ = gettid();
  nameThread(config_.name);
  if (config_.priority > 0) {
    useStack();
    warning_ = setFifoPriority(config_.priority).words();
  }
  const Duration period = config_.rate > 0.0 ? fromSeconds(1.0 / config_.rate) : Duration(0);
  Timestamp deadline = monotonicNow(), due = deadline;  // of the tick: its deadline, before any was skipped
  while (!stopping_) {
    const Timestamp begin = monotonicNow();
    if (period > Duration(0)) {
      lateness_.add(begin - deadline);
      const std::int64_t delay = (begin - due).count();
      if (delay > worst_delay_ns_.load(std::memory_order_relaxed)) {
        worst_delay_ns_.store(delay, std::memory_order_relaxed);
      }
    }
    body_();
    const Timestamp end = monotonicNow();
    duration_.add(end - begin);
    ticks_.fetch_add(1, std::memory_order_release);
    if (period == Duration(0)) continue;
    deadline += period;
    due = deadline;
    if (end > deadline) {
      const auto missed = (end - deadline) / period + 1;
      overruns_.fetch_add(static_cast<std::uint64_t>(missed), std::memory_order_relaxed);
      deadline += missed * period;
    }
    waitUntil(deadline);
  }
}

void Worker::waitUntil(Timestamp deadline) {
  if (wakeup_ == nullptr) return sleepUntil(deadline);
  for (Timestamp now = monotonicNow(); now < deadline && !stopping_; now = monotonicNow()) {
    pollfd waiting{wakeup_->descriptor(), POLLIN, 0};
    const timespec left = timespecOf(deadline - now);
    if (::ppoll(&waiting, 1, &left, nullptr) <= 0) continue;
    wakeup_->clear();
    const Timestamp begin = monotonicNow();
    woken_();
    duration_.add(monotonicNow() - begin);
  }
}

}  // namespace slam
