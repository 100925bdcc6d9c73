// SPDX-License-Identifier: BSD-3-Clause
#include "app/supervisor.hpp"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <stdexcept>
#include <systemd/sd-daemon.h>

#include "app/log.hpp"
#include "runtime/process_usage.hpp"
#include "runtime/realtime.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kPeriod = 100ms;
constexpr Duration kHealthPeriod = 1s;
constexpr Duration kRealtimeStall = 500ms;  // a fixed-rate thread that ticks no more often is stuck
constexpr Duration kConnectStall = 12s;     // the lidar's start-up sequence, resets included
constexpr Duration kGraphStall = 10s;       // an optimisation of a very large map, on a small computer
constexpr Duration kStaleAfter = 1s;        // without a sample
constexpr Duration kSettled = 5s;           // from the start: then rates are judged
constexpr Duration kClockStep = 500ms;

const char* const kStateNames[] = {"ABSENT", "OPENING", "STREAMING", "STALE", "FAULT"};
const char* const kLocalisationNames[] = {"initialising", "localised", "degraded", "lost"};

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

Supervisor::Supervisor(const Config& config)
    : config_(config),
      graph_(config_, exchange_, clock_),
      estimator_(config_, exchange_, graph_.firstLocalizer()),
      mapper_(config_, exchange_, clock_),
      bus_(config_, exchange_, clock_) {
  for (const std::string& file : {config_.output.map, config_.output.record}) {
    const auto folder = std::filesystem::path(file).parent_path();
    if (file.empty() || folder.empty() || std::filesystem::is_directory(folder)) continue;
    throw std::runtime_error(file + ": its folder does not exist; make it, or change [output]");
  }
  if (BaseThread::isWanted(config_)) base_ = std::make_unique<BaseThread>(config_, exchange_);
  if (config_.lidar_device.driver == "rplidar") lidar_ = makeLidarThread(config_, exchange_);

  constexpr double kLidarRate = 5.5, kLcmRate = 0.0;  // [Hz] 0: whatever comes
  if (lidar_) devices_.push_back({"lidar", &lidar_->driver().status(), kLidarRate, ""});
  if (config_.lidar_device.driver == "lcm") devices_.push_back({"lidar", &bus_.lidarStatus(), kLcmRate, ""});
  if (base_ && base_->wheelStatus()) devices_.push_back({"base", base_->wheelStatus(), base_->wheelRate(), ""});
  if (config_.base_device.driver == "lcm") devices_.push_back({"base", &bus_.wheelStatus(), kLcmRate, ""});
  if (base_ && base_->imuStatus()) devices_.push_back({"imu", base_->imuStatus(), base_->imuRate(), ""});
  if (config_.imu_device.driver == "lcm") devices_.push_back({"imu", &bus_.imuStatus(), kLcmRate, ""});

  const DepthDeviceConfig& depth = config_.depth_device;
  if (depth.driver == "openni2") {
    depth_ = makeDepthThread(config_, exchange_);
    devices_.push_back({"depth", &depth_->driver().status(), static_cast<double>(depth.rate), ""});
  }
  if (depth.driver == "lcm") devices_.push_back({"depth", &bus_.depthStatus(), kLcmRate, ""});

  watched_ = {{&estimator_.worker(), kRealtimeStall},
              {&graph_.worker(), kGraphStall},
              {&mapper_.worker(), 2s},
              {&bus_.worker(), 2s}};
  if (base_) watched_.push_back({&base_->worker(), kRealtimeStall});
  if (lidar_) watched_.push_back({&lidar_->worker(), kConnectStall});
  if (depth_) watched_.push_back({&depth_->worker(), kConnectStall});
}

void Supervisor::start() {
  if (config_.runtime.realtime) {
    const std::string problem = lockMemory();
    if (!problem.empty()) logWarning(problem);
  }
  started_ = monotonicNow();
  next_health_ = started_ + kHealthPeriod;
  for (Watched& watched : watched_) {
    watched.moved = started_;
    watched.worker->start();
  }
  sd_notify(0, "READY=1");
  logInfo("running, version " SLAMD_VERSION);
}

int Supervisor::run() {
  start();
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  const timespec period{0, static_cast<long>(kPeriod.count())};
  while (sigtimedwait(&signals, nullptr, &period) < 0) {
    const Timestamp now = monotonicNow();
    exchange_.pose_for_supervisor.load(snapshot_);
    logDeviceChanges();
    logLocalisation();
    warnOnce();
    watch(now);
    if (now >= next_health_) {
      next_health_ += kHealthPeriod;
      measureRates(now);
      sendHealth(now);
    } else if (device_changed_) {
      sendHealth(now);  // news does not wait
    }
  }
  return stop() ? 0 : 1;
}

bool Supervisor::stop() {
  sd_notify(0, "STOPPING=1");
  logInfo("stopping");
  for (Watched& watched : watched_) watched.worker->requestStop();  // all at once, then wait for each
  for (Watched& watched : watched_) {
    if (watched.worker != &mapper_.worker()) watched.worker->stop();
  }
  if (lidar_) lidar_->driver().stop();
  if (depth_) depth_->driver().stop();
  if (base_) base_->stop();
  mapper_.worker().stop();
  graph_.finish();
  const bool drawn = mapper_.finish();
  return graph_.store(mapper_.drawn()) && drawn;
}

void Supervisor::watch(Timestamp now) {
  const Worker* stuck = nullptr;
  for (Watched& watched : watched_) {
    const std::uint64_t ticks = watched.worker->ticks();
    if (ticks != watched.ticks) {
      watched.ticks = ticks;
      watched.moved = now;
    } else if (now - watched.moved > watched.limit) {
      stuck = watched.worker;
    }
  }
  if (stuck == nullptr) sd_notify(0, "WATCHDOG=1");
  if (stuck != nullptr && !stalled_) logError("thread " + stuck->name() + " does not tick: watchdog not fed");
  stalled_ = stuck != nullptr;
}

void Supervisor::warnOnce() {
  for (Watched& watched : watched_) {
    if (watched.warned || watched.worker->ticks() == 0) continue;
    watched.warned = true;
    if (!watched.worker->warning().empty())
      logWarning("thread " + watched.worker->name() + ": " + watched.worker->warning());
  }
  for (const SensorFinding& finding : snapshot_.findings.all()) {
    bool& logged = fault_logged_[static_cast<std::size_t>(finding.fault)];
    if (!logged) logWarning(describe(finding));
    logged = true;
  }
  if (base_ && base_->finding() != std::string_view(base_finding_)) {
    base_finding_ = base_->finding();
    logWarning(std::string("base: ") + base_finding_);
  }
  if (!clock_step_logged_ && std::chrono::abs(clock_.drift()) > kClockStep) {
    clock_step_logged_ = true;
    logWarning("the wall clock was set; stamps go on from the old one");
  }
  if (!bus_logged_ && !bus_.connected() && monotonicNow() - started_ > 1s) {
    bus_logged_ = true;
    logWarning(
        "LCM has no multicast route, nothing is published; mend: ip link set lo multicast on && "
        "ip route add 224.0.0.0/4 dev lo");
  }
}

std::string Supervisor::reasonOf(const Device& device, Timestamp now) const {
  const auto state = device.status->state.load(std::memory_order_acquire);
  const std::int64_t last = device.status->last_sample_ns.load(std::memory_order_relaxed);
  const Duration age = now - Timestamp(Duration(last));
  const std::string reason = device.status->reason.load(std::memory_order_relaxed);
  char text[64];
  constexpr double kSlow = 0.7;  // [1] of the expected rate
  if (reason.empty() && age < kStaleAfter && device.judged && device.rate < kSlow * device.expected) {
    std::snprintf(text, sizeof text, "%.1f Hz where %.1f Hz are expected", device.rate, device.expected);
    return text;
  }
  if (last == 0 || age < kStaleAfter) return reason;
  std::snprintf(text, sizeof text, "no data for %.1f s", toSeconds(age));
  return state == DeviceState::kStreaming ? std::string(text) + ", port present" : std::string(text) + ", " + reason;
}

void Supervisor::logDeviceChanges() {
  for (Device& device : devices_) {
    const auto state = device.status->state.load(std::memory_order_acquire);
    const std::string reason = device.status->reason.load(std::memory_order_relaxed);
    const std::string text = std::string(kStateNames[static_cast<int>(state)]) + (reason.empty() ? "" : ": ") + reason;
    // A device that fails to open goes through OPENING at each try: only news is logged.
    if (state == DeviceState::kOpening || text == device.logged) continue;
    device.logged = text;
    device_changed_ = true;
    state == DeviceState::kStreaming ? logInfo(device.name + " " + text) : logWarning(device.name + " " + text);
  }
}

void Supervisor::logLocalisation() {
  const LocalisationState state = snapshot_.pose.state;
  if (state == logged_localisation_ || state == LocalisationState::kDegraded) return;
  const std::string text = std::string("pose ") + kLocalisationNames[static_cast<int>(state)];
  state == LocalisationState::kLost ? logWarning(text + ": no pose is published until the robot is found in the map")
                                    : logInfo(text);
  logged_localisation_ = state;
}

std::string Supervisor::summary(Timestamp now) const {
  std::string text = std::string("pose ") + kLocalisationNames[static_cast<int>(snapshot_.pose.state)];
  for (const Device& device : devices_) {
    const std::string reason = reasonOf(device, now);
    if (!reason.empty()) text += "; " + device.name + ": " + reason;
  }
  for (const SensorFinding& finding : snapshot_.findings.all()) text += "; " + describe(finding);
  if (*base_finding_ != '\0') text += std::string("; base: ") + base_finding_;
  if (!bus_.connected()) text += "; LCM: no multicast route";
  return text;
}

void Supervisor::measureRates(Timestamp now) {
  const double cpu = cpuSeconds();
  cpu_share_ = (cpu - cpu_) / toSeconds(kHealthPeriod);
  cpu_ = cpu;
  for (Device& device : devices_) {
    const std::int64_t samples = device.status->samples.load(std::memory_order_relaxed);
    device.rate = static_cast<double>(samples - device.samples) / toSeconds(kHealthPeriod);
    device.samples = samples;
    // A second in which the device came or went says nothing of its rate.
    const bool streams = device.status->state == DeviceState::kStreaming;
    device.judged = streams && device.streamed && now - started_ > kSettled;
    device.streamed = streams;
  }
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
  const std::string& file = config_.output.map.empty() ? config_.output.record : config_.output.map;
  health.disk_free_mb = file.empty() ? -1.0 : diskFreeMegabytes(file);

  for (const Device& device : devices_) {
    device_health_t d{};
    d.name = device.name;
    d.state = static_cast<std::uint8_t>(device.status->state.load(std::memory_order_acquire));
    d.reason = reasonOf(device, now);
    const std::int64_t last = device.status->last_sample_ns.load(std::memory_order_relaxed);
    d.age = last == 0 ? -1.0 : toSeconds(now - Timestamp(Duration(last)));
    const bool silent = d.age > toSeconds(kStaleAfter);
    if (silent && d.state == static_cast<std::uint8_t>(DeviceState::kStreaming)) {
      d.state = static_cast<std::uint8_t>(DeviceState::kStale);
    }
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
        counter("scans.retimed", l.scans_retimed),
        counter("scans.too_late", l.scans_too_late),
        counter("clock_resets", l.clock_resets),
        counter("samples.far_ahead", l.far_ahead),
        counter("keyframes", l.keyframes),
        counter("scans.searched", l.searched),
        counter("loop_closures", static_cast<std::uint64_t>(exchange_.loop_closures.load())),
        counter("lost", l.lost),
        counter("relocalised", static_cast<std::uint64_t>(exchange_.relocalised.load())),
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
        counter("lcm.bad_messages", static_cast<std::uint64_t>(exchange_.bad_messages.load()))}) {
    health.counters.push_back(c);
  }
  health.ndevices = static_cast<std::int32_t>(health.devices.size());
  health.nstages = static_cast<std::int32_t>(health.stages.size());
  health.ncounters = static_cast<std::int32_t>(health.counters.size());
  exchange_.health.tryPush(health);
  exchange_.bus_wakeup.notify();
  sd_notify(0, ("STATUS=" + health.summary).c_str());
}

}  // namespace slam
