// SPDX-License-Identifier: BSD-3-Clause
// What the supervisor says in SLAM_HEALTH.
#include <algorithm>
#include <cstdio>
#include <string_view>
#include <systemd/sd-daemon.h>

#include "app/supervisor.hpp"
#include "runtime/process_usage.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kStaleAfter = 900ms;  // without a sample ...
constexpr Duration kLcmStaleAfter = 2s;  // ... that others send, who may be slow
constexpr Duration kSettled = 5s;        // from the start: then rates are judged

counter_t counter(const std::string& name, std::uint64_t value) {
  counter_t c{};
  c.name = name;
  c.value = static_cast<std::int64_t>(value);
  return c;
}

stage_health_t stage(const std::string& name, const LatencyHistogram& histogram) {
  const auto summary = histogram.summary();
  stage_health_t s{};
  s.name = name;
  s.count = summary.count;
  s.p50_us = summary.p50_us;
  s.p99_us = summary.p99_us;
  s.max_us = summary.max_us;
  return s;
}

}  // namespace

std::string Supervisor::statusReason(const Device& device) const {
  if (device.name == "lidar" && exchange_.lidar_stuck) {
    return "every turn shows the same ranges although the robot moves: the lidar is stuck, pull its plug";
  }
  return device.status->reason.load(std::memory_order_acquire);
}

std::optional<Duration> Supervisor::ageOf(const Device& device, Timestamp now) {
  const std::int64_t last = device.status->last_sample_ns.load(std::memory_order_relaxed);
  return last == 0 ? std::nullopt : std::optional(now - Timestamp(Duration(last)));
}

bool Supervisor::isSilent(const Device& device, Timestamp now) {
  return ageOf(device, now) > (device.over_lcm ? kLcmStaleAfter : kStaleAfter);
}

DeviceState Supervisor::stateOf(const Device& device, Timestamp now) {
  const DeviceState state = device.status->state.load(std::memory_order_acquire);
  return state == DeviceState::kStreaming && isSilent(device, now) ? DeviceState::kStale : state;
}

std::string Supervisor::reasonOf(const Device& device, Timestamp now) const {
  const bool silent = isSilent(device, now);
  std::string reason = statusReason(device);
  char text[64];
  constexpr double kSlow = 0.7;  // [1] of the expected rate
  if (reason.empty() && !silent && device.judged && device.rate < kSlow * device.expected) {
    std::snprintf(text, sizeof text, "%.1f Hz where %.1f Hz are expected", device.rate, device.expected);
    return text;
  }
  if (!silent) return reason;
  if (reason.empty()) reason = device.over_lcm ? "nobody sends it over LCM" : "port present";
  constexpr std::string_view kNoData = "no data, ";  // as a driver begins that cannot tell since when
  if (reason.starts_with(kNoData)) reason.erase(0, kNoData.size());
  std::snprintf(text, sizeof text, "no data for %.1f s, ", toSeconds(*ageOf(device, now)));
  return text + reason;
}

std::string Supervisor::summary(Timestamp now) const {
  std::string text = std::string("pose ") + nameOf(snapshot_.pose.state);
  for (const Device& device : devices_) {
    const std::string reason = reasonOf(device, now);
    if (!reason.empty()) text += "; " + device.name + ": " + reason;
  }
  for (const SensorFinding& finding : snapshot_.findings.all()) text += "; " + describe(finding);
  if (!snapshot_.counters.wheels_heard) text += "; the wheels contradict the scans and are not heard";
  if (*base_finding_ != '\0') text += std::string("; base: ") + base_finding_;
  const std::string link = causeOf(bus_.linkState(), bus_.url());
  if (!link.empty()) text += "; LCM: " + link;
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
  for (Device& device : devices_) {
    const std::int64_t samples = device.status->samples.load(std::memory_order_relaxed);
    device.rate = static_cast<double>(samples - device.samples) / interval;
    device.samples = samples;
    // A second in which the device came or went says nothing of its rate.
    const bool streams = stateOf(device, now) == DeviceState::kStreaming;
    device.judged = streams && device.streamed && now - started_ > kSettled;
    device.streamed = streams;
  }
}

void Supervisor::measureDiskSpace() {
  if (!disk_space_.isBusy()) disk_space_.start([this] { disk_free_ = diskFree(); });
}

double Supervisor::diskFree() const {
  const std::string& maps = config_.store.directory;
  double least = -1.0;
  for (const std::string& file :
       {maps.empty() ? maps : maps + "/map", config_.output.map, config_.output.record, config_.depth_device.record}) {
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

  for (const Device& device : devices_) {
    device_health_t d{};
    d.name = device.name;
    d.state = static_cast<std::uint8_t>(stateOf(device, now));
    d.reason = reasonOf(device, now);
    const std::optional<Duration> age = ageOf(device, now);
    d.age = age ? toSeconds(*age) : -1.0;
    d.samples = device.status->samples.load(std::memory_order_relaxed);
    d.rate = device.rate;
    d.expected = device.expected;
    d.rejects = device.status->rejects.load(std::memory_order_relaxed);
    health.devices.push_back(std::move(d));
  }
  for (const Watched& watched : watched_) {
    health.stages.push_back(stage(watched.worker->name() + ".work", watched.worker->duration()));
    if (watched.worker->rate() > 0.0) {
      health.stages.push_back(stage(watched.worker->name() + ".late", watched.worker->lateness()));
      health.counters.push_back(counter(watched.worker->name() + ".overruns", watched.worker->overruns()));
    }
    health.counters.push_back(counter(watched.worker->name() + ".ticks", watched.worker->ticks()));
    const double cpu_ms = 1e3 * watched.worker->cpuSeconds();
    health.counters.push_back(counter(watched.worker->name() + ".cpu_ms", static_cast<std::uint64_t>(cpu_ms)));
  }
  for (const auto& [name, histogram] : {std::pair("match", &exchange_.match),
                                        {"scan_work", &exchange_.scan_work},
                                        {"scan_to_pose", &exchange_.scan_to_pose},
                                        {"depth", &exchange_.depth_work},
                                        {"map", &exchange_.map_update},
                                        {"loop_closure", &exchange_.optimise}}) {
    health.stages.push_back(stage(name, *histogram));
  }
  if (base_) {
    const auto millivolts = static_cast<std::uint64_t>(1000.0F * std::max(0.0F, base_->battery()));
    health.counters.push_back(counter("base.battery_mv", millivolts));
  }
  const LocalizerCounters& l = snapshot_.counters;
  const EkfCounters& f = snapshot_.filter;
  for (const counter_t& c :
       {counter("scans", l.scans),
        counter("scans.matched", l.matched),
        counter("scans.partly_observable", l.partly_observable),
        counter("scans.unmatched", l.unmatched),
        counter("scans.gated", l.gated),
        counter("scans.held", l.scans_held),
        counter("scans.retimed", l.scans_retimed),
        counter("scans.too_late", l.scans_too_late),
        counter("scans.repeated", l.scans_repeated),
        counter("clock_resets", l.clock_resets),
        counter("samples.far_ahead", l.far_ahead),
        counter("wheels.withdrawn", l.wheels_withdrawn),
        counter("wheels.scale_permille", static_cast<std::uint64_t>(std::lround(1000.0 * l.wheels_scale))),
        counter("keyframes", l.keyframes),
        counter("scans.searched", l.searched),
        counter("loop_closures", static_cast<std::uint64_t>(exchange_.loop_closures.load())),
        counter("lost", l.lost),
        counter("relocalised", static_cast<std::uint64_t>(exchange_.relocalised.load())),
        counter("maps.begun_anew", static_cast<std::uint64_t>(exchange_.maps_begun_anew.load())),
        counter("loop_closures.revoked", static_cast<std::uint64_t>(exchange_.revoked_closures.load())),
        counter("samples.late", l.samples_late),
        counter("samples.too_old", l.samples_too_old),
        counter("ekf.wheels_rejected", f.wheels_rejected),
        counter("ekf.gyro_rejected", f.gyro_rejected),
        counter("ekf.poses_rejected", f.poses_rejected),
        counter("ekf.standstill_updates", f.standstill_updates),
        counter("drops.scans", exchange_.scans.drops()),
        counter("drops.wheels", exchange_.wheels.drops()),
        counter("drops.imu", exchange_.imu.drops()),
        counter("views", l.views),
        counter("views.unplaced", l.views_unplaced),
        counter("drops.views", exchange_.views.drops()),
        counter("drops.sights", exchange_.sights.drops()),
        counter("drops.keyframes", exchange_.keyframes.drops()),
        counter("lcm.published", static_cast<std::uint64_t>(exchange_.published.load())),
        counter("lcm.failures", static_cast<std::uint64_t>(exchange_.publish_failures.load())),
        counter("lcm.bad_messages", static_cast<std::uint64_t>(exchange_.bad_messages.load())),
        counter("lcm.fragments", exchange_.lcm_fragments),
        counter("lcm.other_packets", exchange_.lcm_other_packets),
        counter("lcm.dropped", exchange_.lcm_dropped)}) {
    health.counters.push_back(c);
  }
  if (const Recorder* recorder = bus_.recorder()) {
    health.counters.push_back(counter("record.written", recorder->written()));
    health.counters.push_back(counter("record.dropped", recorder->dropped()));
  }
  health.ndevices = static_cast<std::int32_t>(health.devices.size());
  health.nstages = static_cast<std::int32_t>(health.stages.size());
  health.ncounters = static_cast<std::int32_t>(health.counters.size());
  exchange_.health.tryPush(health);
  exchange_.bus_wakeup.notify();
  sd_notify(0, ("STATUS=" + health.summary).c_str());
}

}  // namespace slam
