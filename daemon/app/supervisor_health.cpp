// SPDX-License-Identifier: BSD-3-Clause
// What the supervisor says in SLAM_HEALTH.
#include <algorithm>
#include <systemd/sd-daemon.h>

#include "app/supervisor.hpp"
#include "runtime/process_usage.hpp"

namespace slam {
namespace {

constexpr Duration kSettled = std::chrono::seconds(5);  // from the start: then rates are judged

}  // namespace

std::string Supervisor::statusReason(const WatchedDevice& device) const {
  if (device.name == "lidar" && exchange_.lidar_stuck) {
    return "every turn shows the same ranges although the robot moves: the lidar is stuck, pull its plug";
  }
  return device.status->reason.load(std::memory_order_acquire);
}

std::string Supervisor::summary(Timestamp now) const {
  std::string text = std::string("pose ") + nameOf(snapshot_.pose.state);
  for (const WatchedDevice& device : devices_) {
    const std::string reason = reasonOf(device, statusReason(device), now);
    if (!reason.empty()) text += "; " + device.name + ": " + reason;
  }
  for (const SensorFinding& finding : snapshot_.findings.all()) text += "; " + describe(finding);
  if (!snapshot_.counters.wheels_heard) text += "; the wheels contradict the scans and are not heard";
  if (*base_finding_ != '\0') text += std::string("; base: ") + base_finding_;
  const std::string link = causeOf(bus_.linkState(), bus_.url());
  if (!link.empty()) text += "; LCM: " + link;
  if (const std::string socket = bus_.socketProblem(); !socket.empty()) text += "; " + socket;
  text += storageWords(now);
  if (const std::string threads = watchdog_.words(now); !threads.empty()) text += "; " + threads;
  if (!not_locked_.empty()) text += "; " + not_locked_;
  return text;
}

void Supervisor::measureRates(Timestamp now) {
  const double interval = toSeconds(now - measured_), cpu = cpuSeconds();
  measured_ = now;
  measureDiskSpace();
  cpu_share_ = (cpu - cpu_) / interval;
  cpu_ = cpu;
  for (WatchedDevice& device : devices_) measureRate(device, interval, now - started_ > kSettled, now);
}

void Supervisor::measureDiskSpace() {
  if (!disk_space_.isBusy()) disk_space_.start([this] { disk_free_ = diskFree(); });
}

double Supervisor::diskFree() const {
  const std::string &maps = config_.store.directory, &log = config_.log.directory;
  double least = -1.0;
  for (const std::string& file : {maps.empty() ? maps : maps + "/map", config_.output.map, config_.output.record,
                                  config_.depth_device.record, log.empty() ? log : log + "/run"}) {
    const double free = file.empty() ? -1.0 : diskFreeMegabytes(file);
    if (free >= 0.0) least = least < 0.0 ? free : std::min(least, free);
  }
  return least;
}

void Supervisor::sendHealth(Timestamp now) {
  device_changed_ = false;
  health_t health{};
  health.utime = clock_.utime(now);
  health.uptime = toSeconds(now - started_);
  health.localisation = static_cast<std::uint8_t>(snapshot_.pose.state);
  health.summary = summary(now);
  health.cpu = cpu_share_;
  health.memory_mb = residentMegabytes();
  health.disk_free_mb = disk_free_;

  for (const WatchedDevice& device : devices_) {
    device_health_t d{};
    d.name = device.name;
    d.state = static_cast<std::uint8_t>(stateOf(device, now));
    d.reason = reasonOf(device, statusReason(device), now);
    const std::optional<Duration> age = ageOf(device, now);
    d.age = age ? toSeconds(*age) : -1.0;
    d.samples = device.status->samples.load(std::memory_order_relaxed);
    d.rate = device.rate;
    d.expected = device.expected;
    d.rejects = device.status->rejects.load(std::memory_order_relaxed);
    health.devices.push_back(std::move(d));
  }
  for (const Watched& watched : watched_) {
    health.stages.push_back(stageOf(watched.worker->name() + ".work", watched.worker->duration()));
    if (watched.worker->rate() > 0.0) {
      health.stages.push_back(stageOf(watched.worker->name() + ".late", watched.worker->lateness()));
      health.counters.push_back(counterOf(watched.worker->name() + ".overruns", watched.worker->overruns()));
    }
    health.counters.push_back(counterOf(watched.worker->name() + ".ticks", watched.worker->ticks()));
    const double cpu_ms = 1e3 * watched.worker->cpuSeconds();
    health.counters.push_back(counterOf(watched.worker->name() + ".cpu_ms", static_cast<std::uint64_t>(cpu_ms)));
  }
  for (stage_health_t& s : stagesOf(exchange_)) health.stages.push_back(std::move(s));
  if (base_) {
    const auto millivolts = static_cast<std::uint64_t>(1000.0F * std::max(0.0F, base_->battery()));
    health.counters.push_back(counterOf("base.battery_mv", millivolts));
  }
  for (counter_t& c : countersOf(snapshot_, exchange_)) health.counters.push_back(std::move(c));
  for (const Recorder* recorder : {bus_.recorder(), bus_.logRecorder()}) {
    if (recorder == nullptr) continue;
    health.counters.push_back(counterOf(recorder->name() + ".written", recorder->written()));
    health.counters.push_back(counterOf(recorder->name() + ".dropped", recorder->dropped()));
  }
  if (const FieldLog* log = bus_.fieldLog())
    health.counters.push_back(counterOf("log.running", log->isRunning() ? 1 : 0));
  health.ndevices = static_cast<std::int32_t>(health.devices.size());
  health.nstages = static_cast<std::int32_t>(health.stages.size());
  health.ncounters = static_cast<std::int32_t>(health.counters.size());
  exchange_.health.tryPush(health);
  exchange_.bus_wakeup.notify();
  sd_notify(0, ("STATUS=" + health.summary).c_str());
}

}  // namespace slam
