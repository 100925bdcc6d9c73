// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/thread_watchdog.hpp"

#include <systemd/sd-daemon.h>
#include <utility>

#include "app/log/log.hpp"

namespace slam {

void ThreadWatchdog::add(Worker& worker, const SilenceLimits& limits, const DeviceStatus* connects) {
  workers_.push_back(&worker);
  connects_.push_back(connects);
  warned_.push_back(false);
  uses_.emplace_back();
  watchdog_.add(worker.name(), limits);
}

void ThreadWatchdog::look(Timestamp now) {
  const Duration step = now - std::exchange(looked_, now).value_or(now);
  for (std::size_t i = 0; i < workers_.size(); ++i) {
    Worker& worker = *workers_[i];
    if (!warned_[i] && worker.ticks() > 0) {
      warned_[i] = true;
      if (!worker.warning().empty()) logWarning("thread " + worker.name() + ": " + worker.warning());
    }
    if (connects_[i] != nullptr && connects_[i]->state != DeviceState::kStreaming) watchdog_.excuse(i);
    const std::optional<ThreadUse> use = worker.use();
    const Duration starved = use && uses_[i] ? starvedBetween(*uses_[i], *use, step) : Duration(0);
    uses_[i] = use;
    watchdog_.look(i, worker.ticks(), worker.takeWorstDelay(), starved, now);
  }
  if (watchdog_.allAlive()) sd_notify(0, "WATCHDOG=1");
  for (const Watchdog::News& news : watchdog_.takeNews(now)) {
    const auto level = news.is_error ? LogLine::kError : LogLine::kWarning;
    if (const auto line = log_.happened(news.thread, news.problem, news.problem.words(), level, now)) logLine(*line);
  }
}

}  // namespace slam
