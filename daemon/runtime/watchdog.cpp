// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/watchdog.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kRemembered = 30s;   // lateness that problems() still names
constexpr Duration kLogInterval = 60s;  // between two lines about one thread's lateness, or about the load
constexpr Duration kStarves = 1s;       // longer than it does anything else, a thread waits for the CPU: an overload

}  // namespace

std::size_t Watchdog::add(std::string name, const SilenceLimits& limits) {
  threads_.push_back({.name = std::move(name), .limits = limits});
  return threads_.size() - 1;
}

void Watchdog::look(std::size_t index, std::uint64_t ticks, Duration lateness, Duration starved, Timestamp now) {
  Thread& thread = threads_[index];
  const Duration step = thread.looked ? std::min(now - *thread.looked, longest_step_) : Duration(0);
  starved = std::min(starved, step);
  thread.looked = now;
  thread.silent += step;
  thread.starved += starved;
  thread.debt = std::clamp(thread.debt + 2 * starved - step, Duration(0), 2 * kStarves);
  if (thread.debt > kStarves) noteOverload(thread, std::max(thread.starved, thread.debt), now);
  const Duration waited = thread.starved;
  if (std::exchange(thread.ticks, ticks) != ticks) thread.silent = thread.starved = Duration(0);
  const Duration late = std::exchange(thread.excused, false) ? Duration(0) : std::max(thread.silent, lateness);
  if (late <= thread.limits.late) return;
  if (2 * waited > late) return noteOverload(thread, waited, now);
  if (!thread.was_late || now - *thread.was_late > kRemembered) thread.worst = Duration(0);
  thread.was_late = now;
  thread.worst = std::max(thread.worst, late);
  thread.unlogged = std::max(thread.unlogged, late);
}

void Watchdog::noteOverload(const Thread& thread, Duration waited, Timestamp now) {
  if (!isOverloaded(now)) overload_.waited = Duration(0);
  overload_.last = now;
  if (waited <= overload_.waited) return;
  overload_.waited = waited;
  overload_.thread = thread.name;
}

bool Watchdog::isOverloaded(Timestamp now) const { return overload_.last && now - *overload_.last <= kRemembered; }

bool Watchdog::allAlive() const {
  return std::none_of(threads_.begin(), threads_.end(),
                      [](const Thread& thread) { return thread.limits.vital && thread.isDead(); });
}

Problem Watchdog::late(const Thread& thread, Duration lateness) {
  return {problem::kThreadLate, {1e3 * toSeconds(lateness)}, {thread.name}};
}

Problem Watchdog::overload() const { return {problem::kOverloaded, {toSeconds(overload_.waited)}, {overload_.thread}}; }

std::vector<Problem> Watchdog::problems(Timestamp now) const {
  std::vector<Problem> problems;
  if (isOverloaded(now)) problems.push_back(overload());
  for (const Thread& thread : threads_) {
    const bool was_late = thread.was_late && now - *thread.was_late <= kRemembered && !isOverloaded(now);
    if (was_late || thread.isDead()) problems.push_back(thread.isDead() ? dead(thread) : late(thread, thread.worst));
  }
  return problems;
}

std::vector<Watchdog::News> Watchdog::takeNews(Timestamp now) {
  std::vector<News> news;
  const bool overloaded = isOverloaded(now);
  if (overloaded && (!overload_.logged || now - *overload_.logged >= kLogInterval)) {
    overload_.logged = now;
    news.push_back({false, "computer", overload()});
  }
  for (Thread& thread : threads_) {
    if (thread.isDead()) {
      if (!std::exchange(thread.death_logged, true)) news.push_back({true, thread.name, dead(thread)});
      continue;
    }
    thread.death_logged = false;
    if (overloaded) thread.unlogged = Duration(0);  // one cause
    const bool over = thread.unlogged > Duration(0) && thread.silent == Duration(0);
    if (!over || (thread.logged && now - *thread.logged < kLogInterval)) continue;
    thread.logged = now;
    news.push_back({false, thread.name, late(thread, std::exchange(thread.unlogged, Duration(0)))});
  }
  return news;
}

}  // namespace slam
