// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cmath>
#include <slam/counter_t.hpp>
#include <slam/stage_health_t.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "app/counters.hpp"
#include "app/device_monitor.hpp"
#include "config/config.hpp"
#include "runtime/clock.hpp"
#include "runtime/job_thread.hpp"

namespace slam {

template <typename Value>
counter_t counterOf(const CounterInfo& what, const Value& value) {
  constexpr bool kIsShare = std::is_floating_point_v<Value>;  // a message holds whole numbers
  counter_t c{};
  c.name = what.name + (kIsShare ? "_permille" : "");
  if constexpr (kIsShare) {
    c.value = std::lround(1000.0 * value);
  } else {
    c.value = static_cast<std::int64_t>(value);
  }
  return c;
}

/// What the front end has found out about the sensors.
std::vector<Trouble> sensorTroubles(const PoseSnapshot& pose);

stage_health_t stageOf(const std::string& name, const LatencyHistogram& histogram);

/// Makes SLAM_HEALTH, SLAM_PROBLEMS, and systemd's STATUS, of what the threads show.
class HealthReporter {
 public:
  HealthReporter(const Config& config, const WallClock& clock, DeviceMonitor& devices,
                 const Producer<HealthReport>& messages, Wakeup& bus_wakeup)
      : config_(config), clock_(clock), devices_(devices), messages_(messages), bus_wakeup_(bus_wakeup) {}

  void begin(Timestamp now);
  /// Measures rates once a second. @return whether it has: a message is due
  bool measure(Timestamp now);
  /// @param others beside those of pose, devices and sensors
  void send(Timestamp now, const PoseSnapshot& pose, const std::vector<Trouble>& others, const Counted& counted);
  /// Whether a disk keeps who asks for its room: then its thread cannot be joined.
  bool isBusy() const { return disk_space_.isBusy(); }

 private:
  void measureDiskSpace();
  double diskFree() const;  // [MB] where maps and records are written, the least; -1: not known

  const Config& config_;
  const WallClock& clock_;
  DeviceMonitor& devices_;
  const Producer<HealthReport> messages_;
  Wakeup& bus_wakeup_;
  Timestamp started_{}, next_{};
  Timestamp measured_{};                 // when rates were
  double cpu_ = 0.0;                     // [s] when rates were measured last
  double cpu_share_ = 0.0;               // [1] of a core, then
  std::atomic<double> disk_free_{-1.0};  // [MB] as diskFree()
  JobThread disk_space_{"disk space"};   // a network disk may keep who asks waiting
};

}  // namespace slam
