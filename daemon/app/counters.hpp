// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/channels.hpp"
#include "app/log/recorder.hpp"
#include "drivers/device_status.hpp"
#include "runtime/worker.hpp"

namespace slam {

template <typename Visitor>
void visitCounters(const Worker& thread, Visitor&& visit) {
  const std::string name = thread.name() + ".";
  visit(CounterInfo{name + "ticks", "turns", "Turns of the thread's loop."}, thread.ticks());
  if (thread.rate() > 0.0)
    visit(CounterInfo{name + "overruns", "turns", "Turns that ended when the next one was due already."},
          thread.overruns());
  visit(CounterInfo{name + "cpu_ms", "ms", "CPU time that the thread has used."},
        static_cast<std::uint64_t>(1e3 * thread.cpuSeconds()));
}

/// Of log.running.
enum LogState : std::uint8_t { kLogStopped, kLogWritten, kLogFails };

/// All that is counted, wherever it is; nullptr, none: this slamd does not have it.
struct Counted {
  const FrontEndCounters* front_end = nullptr;
  const EkfCounters* filter = nullptr;
  const BackEndCounters* back_end = nullptr;
  const Channels* channels = nullptr;
  std::vector<const Worker*> threads = {};
  std::vector<std::pair<std::string, const DeviceStatus*>> devices = {};
  const CanLinkCounters* can = nullptr;
  std::vector<std::pair<std::string, const RecorderCounters*>> recorders = {};
  std::optional<float> battery = {};  ///< [V]
  std::optional<std::uint64_t> limited_speeds = {};
  std::optional<LogState> logs = {};
  std::optional<double> echoes = {};  ///< [1] of the beams of the last turn
};

/// Those that slam-replay has, too.
template <typename Visitor>
void visitPipelineCounters(const Counted& all, Visitor&& visit) {
  if (all.front_end != nullptr) visitCounters(*all.front_end, visit);
  if (all.filter != nullptr) visitCounters(*all.filter, visit);
  if (all.back_end != nullptr) visitCounters(*all.back_end, visit);
}

template <typename Visitor>
void visitDaemonCounters(const Counted& all, Visitor&& visit) {
  if (all.channels != nullptr) visitCounters(*all.channels, visit);
  for (const Worker* thread : all.threads) visitCounters(*thread, visit);
  for (const auto& [name, status] : all.devices) {
    if (const std::int64_t thinned = status->thinned.load(std::memory_order_relaxed); thinned > 0)
      visit(
          CounterInfo{name + ".thinned", "beams", "Left out evenly because there were too many; shown where any were."},
          thinned);
  }
  if (all.can != nullptr) visitCounters(*all.can, visit);
  if (all.battery)
    visit(CounterInfo{"base.battery_mv", "mV", "Voltage of the board's battery; 0: not known."},
          static_cast<std::uint64_t>(1000.0F * std::max(0.0F, *all.battery)));
  if (all.limited_speeds)
    visit(CounterInfo{"base.limited", "messages",
                      "SLAM_DRIVE above base.max_speed or base.max_turn_rate, driven slower on the same curve."},
          *all.limited_speeds);
  if (all.echoes)
    visit(CounterInfo{"lidar.echoes", "1", "Share of the last turn's beams that can be used."}, *all.echoes);
  for (const auto& [name, counters] : all.recorders) visitCounters(*counters, name, visit);
  if (all.logs)
    visit(CounterInfo{"log.running", "1", "1 while the field log is written, 2 while it cannot be; 0: it is stopped."},
          static_cast<int>(*all.logs));
}

/// docs/counters.md
std::string printCounters();

}  // namespace slam
