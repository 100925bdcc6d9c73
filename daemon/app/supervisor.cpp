// SPDX-License-Identifier: BSD-3-Clause
#include "app/supervisor.hpp"

#include <algorithm>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <stdexcept>
#include <systemd/sd-daemon.h>

#include "app/log.hpp"
#include "runtime/realtime.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kPeriod = 100ms;
constexpr Duration kRealtimeStall = 500ms;           // a fixed-rate thread that ticks no more often is stuck
constexpr Duration kConnectStall = 12s;              // the lidar's start-up sequence, resets included
constexpr Duration kGraphStall = 10s;                // an optimisation of a very large map, on a small computer
constexpr double kMostLines = 5.0, kLineRate = 0.5;  // [1], [1/s] of the log about one device
constexpr Duration kClockStep = 500ms;

/// Runs before the map is loaded: that may take seconds, and a slamd that was killed may have left the wheels turning.
std::unique_ptr<BaseThread> startBase(const Config& config, Exchange& exchange) {
  if (!BaseThread::isWanted(config)) return nullptr;
  auto base = std::make_unique<BaseThread>(config, exchange);
  base->worker().start();
  return base;
}

}  // namespace

Supervisor::Supervisor(const Config& config)
    : config_(config),
      base_(startBase(config_, exchange_)),
      graph_(config_, exchange_, clock_),
      estimator_(config_, exchange_, graph_.firstLocalizer()),
      mapper_(config_, exchange_, clock_),
      bus_(config_, exchange_, clock_) {
  for (const std::string& file : {config_.output.map, config_.output.record}) {
    const auto folder = std::filesystem::path(file).parent_path();
    if (file.empty() || folder.empty() || std::filesystem::is_directory(folder)) continue;
    throw std::runtime_error(file + ": its folder does not exist; make it, or change [output]");
  }
  if (config_.lidar_device.driver == "rplidar") lidar_ = makeLidarThread(config_, exchange_);

  constexpr double kLidarRate = 5.5, kLcmRate = 0.0;  // [Hz] 0: whatever comes
  if (lidar_) devices_.push_back({"lidar", &lidar_->driver().status(), kLidarRate});
  if (config_.lidar_device.driver == "lcm") devices_.push_back({"lidar", &bus_.lidarStatus(), kLcmRate, true});
  if (base_ && base_->wheelStatus()) devices_.push_back({"base", base_->wheelStatus(), base_->wheelRate()});
  if (config_.base_device.driver == "lcm") devices_.push_back({"base", &bus_.wheelStatus(), kLcmRate, true});
  if (base_ && base_->imuStatus()) devices_.push_back({"imu", base_->imuStatus(), base_->imuRate()});
  if (config_.imu_device.driver == "lcm") devices_.push_back({"imu", &bus_.imuStatus(), kLcmRate, true});

  const DepthDeviceConfig& depth = config_.depth_device;
  if (depth.driver == "openni2") {
    depth_ = makeDepthThread(config_, exchange_);
    devices_.push_back({"depth", &depth_->driver().status(), static_cast<double>(depth.rate)});
  }
  if (depth.driver == "lcm") devices_.push_back({"depth", &bus_.depthStatus(), kLcmRate, true});

  watched_ = {{&estimator_.worker(), kRealtimeStall},
              {&graph_.worker(), kGraphStall},
              {&mapper_.worker(), 2s},
              {&bus_.worker(), 2s}};
  if (base_) watched_.push_back({&base_->worker(), kRealtimeStall});
  if (lidar_) watched_.push_back({&lidar_->worker(), kConnectStall});
  if (depth_) watched_.push_back({.worker = &depth_->worker(), .limit = kConnectStall, .vital = false});
}

Supervisor::~Supervisor() {
  if (base_) base_->stop();  // before the others are joined, which may take long
}

sigset_t Supervisor::stopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  struct sigaction hang_up {};
  sigaction(SIGHUP, nullptr, &hang_up);
  if (hang_up.sa_handler != SIG_IGN) sigaddset(&signals, SIGHUP);
  return signals;
}

void Supervisor::start() {
  if (config_.runtime.realtime) {
    const std::string problem = lockMemory();
    if (!problem.empty()) logWarning(problem);
  }
  started_ = monotonicNow();
  next_health_ = started_ + kHealthPeriod;
  measured_ = started_;
  // What the base has measured while the map was loaded has gaps, its queues were full, and it counts for no rate.
  exchange_.wheels.drain([](const WheelReading&) {});
  exchange_.imu.drain([](const ImuSample&) {});
  exchange_.wheels_out.drain([](const WheelReading&) {});
  exchange_.imu_out.drain([](const ImuSample&) {});
  for (Device& device : devices_) device.samples = device.status->samples;
  for (Watched& watched : watched_) {
    watched.moved = started_;
    if (!base_ || watched.worker != &base_->worker()) watched.worker->start();
  }
  sd_notify(0, "READY=1");
  logInfo("running, version " SLAMD_VERSION);
}

int Supervisor::run() {
  start();
  const sigset_t signals = stopSignals();
  const timespec period{0, static_cast<long>(kPeriod.count())};
  while (sigtimedwait(&signals, nullptr, &period) < 0) {
    const Timestamp now = monotonicNow();
    exchange_.pose_for_supervisor.load(snapshot_);
    logDeviceChanges();
    logLocalisation();
    logLink();
    warnOnce();
    watch(now);
    if (now >= next_health_) {
      next_health_ = std::max(next_health_ + kHealthPeriod, now);
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
  if (base_) base_->stop();  // first: another thread may take long, and the wheels must not turn meanwhile
  for (Watched& watched : watched_) {
    if (watched.worker != &mapper_.worker()) watched.worker->stop();
  }
  if (lidar_) lidar_->driver().stop();
  if (depth_) depth_->driver().stop();
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
      if (watched.vital) stuck = watched.worker;
      if (!watched.vital && !watched.stall_logged)
        logError("thread " + watched.worker->name() + " does not tick: its device is stuck");
      watched.stall_logged = true;
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
}

void Supervisor::logLink() {
  const LinkState state = bus_.linkState();
  if (state == link_logged_ || state == LinkState::kOpening) return;
  if (isFault(state)) {
    const char* const lost =
        state == LinkState::kUnheard ? "commands and samples may not arrive" : "nothing is published";
    logWarning("LCM: " + causeOf(state, bus_.url()) + "; " + lost +
               ", pose, map and store go on; fix: " + fixOf(state, bus_.url()));
  } else if (link_logged_ == LinkState::kOpening) {
    logInfo("LCM connected: " + bus_.url().text);
  } else {
    logInfo("LCM messages are sent again");
  }
  link_logged_ = state;
  device_changed_ = true;
}

void Supervisor::logDeviceChanges() {
  for (Device& device : devices_) {
    const Timestamp now = monotonicNow();
    const DeviceState state = stateOf(device, now);
    std::string reason = statusReason(device);
    if (state == DeviceState::kStale && reason.empty()) reason = "no data";
    const std::string text = std::string(nameOf(state)) + (reason.empty() ? "" : ": ") + reason;
    // A device that fails to open goes through OPENING at each try: only news is logged.
    const bool known_lost = state == DeviceState::kOpening && !device.logged.starts_with("STREAMING");
    if (known_lost || text == device.logged) continue;
    // One that alternates for long tells so every two seconds.
    device.lines = std::min(kMostLines, device.lines + kLineRate * toSeconds(now - device.looked));
    device.looked = now;
    if (device.lines < 1.0) continue;
    device.lines -= 1.0;
    device.logged = text;
    device_changed_ = true;
    state == DeviceState::kStreaming ? logInfo(device.name + " " + text) : logWarning(device.name + " " + text);
  }
}

void Supervisor::logLocalisation() {
  const LocalisationState state = snapshot_.pose.state;
  if (state == logged_localisation_ || state == LocalisationState::kDegraded) return;
  const std::string text = std::string("pose ") + nameOf(state);
  state == LocalisationState::kLost ? logWarning(text + ": no pose is published until the robot is found in the map")
                                    : logInfo(text);
  logged_localisation_ = state;
}

}  // namespace slam
