// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/bus_thread.hpp"

#include <chrono>
#include <iterator>
#include <poll.h>
#include <utility>

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr int kWait = 50;                  // [ms] without a wake-up
constexpr Duration kClockSetBack = 500ms;  // more than a clock is slewed by at once

}  // namespace

BusThread::BusThread(const Config& config, const BusEnds& ends, const WallClock& clock)
    : ends_(ends),
      clock_(clock),
      publisher_(config, ends_, clock),
      sensors_(config, ends_, clock, publisher_),
      drives_(config, ends_, clock, publisher_),
      commands_(config, ends_, clock, publisher_),
      worker_({.name = "bus"}, [this] { tick(); }) {}

void BusThread::tick() {
  LcmLink& link = publisher_.link();
  LocalSocket& socket = commands_.socket();
  pollfd waiting[] = {
      {ends_.wakeup.descriptor(), POLLIN, 0}, {link.descriptor(), POLLIN, 0}, {socket.descriptor(), POLLIN, 0}};
  ::poll(waiting, std::size(waiting), kWait);
  ends_.wakeup.clear();
  publisher_.takePoses();
  followClock();
  drives_.sendOwedStop();
  link.receive();
  link.tend(monotonicNow());
  socket.receive();
  socket.tend(monotonicNow());
  publisher_.publishSamples();
  commands_.answer();
  publisher_.publishMap();
  publisher_.publishHealth(socket);
  const Timestamp now = monotonicNow();
  publisher_.report(now);
  commands_.report();
  drives_.report(now);
}

/// What is known of others' clocks counts from ours.
void BusThread::followClock() {
  const Duration drift = clock_.drift(), ahead = drift < -kClockSetBack ? -drift : Duration(0);
  const bool set = std::chrono::abs(ahead - ahead_) > kClockSetBack;
  if (set) ahead_ = ahead;
  if (std::exchange(followed_, clock_.followed()) == followed_ && !set) return;
  sensors_.beginClocks(ahead_);
  drives_.beginClocks(ahead_);
}

}  // namespace slam
