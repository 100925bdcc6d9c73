// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/watchdog.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kRemembered = 30s;   // lateness that words() still names
constexpr Duration kLogInterval = 60s;  // between two lines about one thread's lateness

}  // namespace

std::size_t Watchdog::add(std::string name, const SilenceLimits& limits) {
  threads_.push_back({.name = std::move(name), .limits = limits});
  return threads_.size() - 1;
}

void Watchdog::look(std::size_t index, std::uint64_t ticks, Duration lateness, Timestamp now) {
  Thread& thread = threads_[index];
  const Duration step = thread.looked ? std::min(now - *thread.looked, longest_step_) : Duration(0);
  thread.looked = now;
  thread.silent = std::exchange(thread.ticks, ticks) == ticks ? thread.silent + step : Duration(0);
  const Duration late = std::exchange(thread.excused, false) ? Duration(0) : std::max(thread.silent, lateness);
  if (late <= thread.limits.late) return;
  if (!thread.was_late || now - *thread.was_late > kRemembered) thread.worst = Duration(0);
  thread.was_late = now;
  thread.worst = std::max(thread.worst, late);
  thread.unlogged = std::max(thread.unlogged, late);
}

bool Watchdog::allAlive() const {
  return std::none_of(threads_.begin(), threads_.end(),
                      [](const Thread& thread) { return thread.limits.vital && thread.isDead(); });
}

std::string Watchdog::lateWords(const Thread& thread, Duration lateness) {
  return "thread " + thread.name + " was late: " + std::to_string(std::lround(1e3 * toSeconds(lateness))) +
         " ms; is the computer overloaded?";
}

std::string Watchdog::deadWords(const Thread& thread) {
  return "thread " + thread.name + " does not tick: " +
         (thread.limits.vital ? "the watchdog is not fed, so that systemd starts slamd anew" : "its device is stuck");
}

std::string Watchdog::words(Timestamp now) const {
  std::string text;
  for (const Thread& thread : threads_) {
    const bool late = thread.was_late && now - *thread.was_late <= kRemembered;
    if (!late && !thread.isDead()) continue;
    if (!text.empty()) text += "; ";
    text += thread.isDead() ? deadWords(thread) : lateWords(thread, thread.worst);
  }
  return text;
}

std::vector<Watchdog::News> Watchdog::takeNews(Timestamp now) {
  std::vector<News> news;
  for (Thread& thread : threads_) {
    if (thread.isDead()) {
      if (!std::exchange(thread.death_logged, true)) news.push_back({true, thread.name, deadWords(thread)});
      continue;
    }
    thread.death_logged = false;
    const bool over = thread.unlogged > Duration(0) && thread.silent == Duration(0);
    if (!over || (thread.logged && now - *thread.logged < kLogInterval)) continue;
    thread.logged = now;
    news.push_back({false, thread.name, lateWords(thread, std::exchange(thread.unlogged, Duration(0)))});
  }
  return news;
}

}  // namespace slam
