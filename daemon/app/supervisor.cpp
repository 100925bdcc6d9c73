// SPDX-License-Identifier: BSD-3-Clause
#include "app/supervisor.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <systemd/sd-daemon.h>

#include "app/log.hpp"
#include "runtime/realtime.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kPeriod = 100ms;
// On an overloaded computer a thread waits for others, and for kernel threads of normal priority: reading a serial port
// took up to 3.8 s. Starting slamd anew would not help any of that, it would only end the pose. A dead thread is one
// that waits longer than any of this can last. Until then, what it commands no more is the drives' watchdogs' business.
constexpr Duration kDead = 10s;
constexpr Duration kConnecting = 12s;      // the lidar's start-up sequence, resets included
constexpr Duration kOptimising = 10s;      // a very large map, on a small computer
constexpr Duration kRealtimeLate = 200ms;  // of a period of 2 to 10 ms
constexpr Duration kReadingLate = 500ms;   // of a wait of 100 ms at most
constexpr Duration kDrawingLate = 2s;      // a large map anew
constexpr Duration kDiskHangs = 3s;        // in one piece of work
constexpr Duration kStopLimit = 15s;       // for the disk; systemd waits for 20 s
constexpr Duration kRecordLimit = 3s;      // for the disk, at the end
const char* const kHung = ": the disk has not answered in time";
const char* const kNoAnswer =
    ": the disk does not answer, slamd goes on and writes what is new when it does; is it broken, or too slow?";
constexpr Duration kLogInterval = 60s;               // between two lines about a disk that hangs
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
      bus_(config_, exchange_, clock_),
      watchdog_(kPeriod) {
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
    std::function<std::string()> record_to;
    if (FieldLog* log = bus_.fieldLog(); log != nullptr && config_.log.images && depth.record.empty())
      record_to = [log] { return log->imagesPath(); };
    depth_ = makeDepthThread(config_, exchange_, std::move(record_to));
    devices_.push_back({"depth", &depth_->driver().status(), static_cast<double>(depth.rate)});
  }
  if (depth.driver == "lcm") devices_.push_back({"depth", &bus_.depthStatus(), kLcmRate, true});

  watched_ = {{&estimator_.worker(), {kRealtimeLate, kDead}},
              {&graph_.worker(), {kOptimising, kOptimising + kDead}},
              {&mapper_.worker(), {kDrawingLate, kDrawingLate + kDead}},
              {&bus_.worker(), {kReadingLate, kDead}}};
  if (base_) watched_.push_back({&base_->worker(), {kRealtimeLate, kDead}});
  if (lidar_) {
    watched_.push_back({&lidar_->worker(), {kReadingLate, kConnecting + kDead}, &lidar_->driver().status()});
  }
  if (depth_) {  // OpenNI2's calls may hang
    watched_.push_back({&depth_->worker(), {kReadingLate, kConnecting, /*vital=*/false}, &depth_->driver().status()});
  }
  for (const Watched& watched : watched_) watchdog_.add(watched.worker->name(), watched.limits);

  stored_.push_back({"map", [this](Timestamp now) { return graph_.storage(now); }});
  stored_.push_back({"map files", [this](Timestamp now) { return mapper_.storage(now); }});
  if (Recorder* recorder = bus_.recorder()) {
    stored_.push_back({"record", [recorder](Timestamp now) { return recorder->report(now); }});
  }
  if (Recorder* log = bus_.logRecorder()) stored_.push_back({"log", [log](Timestamp now) { return log->report(now); }});
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
    not_locked_ = lockMemory();
    if (!not_locked_.empty()) logWarning(not_locked_);
  }
  started_ = monotonicNow();
  next_health_ = started_ + kHealthPeriod;
  measured_ = started_;
  // What the base has measured while the map was loaded has gaps, its queues were full, and it counts for no rate.
  exchange_.wheels.drain([](const WheelReading&) {});
  exchange_.imu.drain([](const ImuSample&) {});
  exchange_.wheels_out.drain([](const WheelReading&) {});
  exchange_.imu_out.drain([](const ImuSample&) {});
  for (WatchedDevice& device : devices_) device.samples = device.status->samples;
  for (Watched& watched : watched_) {
    if (!base_ || watched.worker != &base_->worker()) watched.worker->start();
  }
  sd_notify(0, "READY=1");
  logInfo("running, version " SLAMD_VERSION);
}

int Supervisor::run() {
  start();
  const sigset_t signals = stopSignals();
  measureDiskSpace();
  const timespec period{0, static_cast<long>(kPeriod.count())};
  while (sigtimedwait(&signals, nullptr, &period) < 0) {
    const Timestamp now = monotonicNow();
    exchange_.pose_for_supervisor.load(snapshot_);
    logDeviceChanges();
    logLocalisation();
    logLink();
    warnOnce();
    watch(now);
    watchDisks(now);
    if (now >= next_health_) {
      next_health_ = std::max(next_health_ + kHealthPeriod, now);
      measureRates(now);
      sendHealth(now);
    } else if (device_changed_) {
      sendHealth(now);  // news does not wait
    }
  }
  const bool saved = stop();
  if (graph_.isWriting() || mapper_.isWriting() || recorder_hangs_ || disk_space_.isBusy()) {
    std::_Exit(saved ? 0 : 1);  // a thread that waits for a disk cannot be joined
  }
  return saved ? 0 : 1;
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
  const Timestamp now = monotonicNow();
  graph_.finish();
  mapper_.finish();
  graph_.store(mapper_.drawn());
  for (Recorder* recorder : {bus_.recorder(), bus_.logRecorder()}) {
    if (recorder == nullptr) continue;
    if (!recorder->finish(now + kRecordLimit))
      logError("the " + recorder->name() + "'s end is lost: the disk has not taken it");
    recorder_hangs_ |= recorder->report(now).waiting > Duration(0);
  }
  if (bus_.fieldLog() != nullptr) recorder_hangs_ |= bus_.fieldLog()->keeperHangs(now + kRecordLimit);
  const bool drawn = mapper_.waitUntilSaved(now + kStopLimit), stored = graph_.waitUntilStored(now + kStopLimit);
  if (!drawn) logError("the map files are not saved" + std::string(mapper_.isWriting() ? kHung : ""));
  if (!stored) logError("the map is not stored" + std::string(graph_.isWriting() ? kHung : ""));
  return drawn && stored;
}

void Supervisor::watch(Timestamp now) {
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    const Watched& watched = watched_[i];
    const bool connecting = watched.connects != nullptr && watched.connects->state != DeviceState::kStreaming;
    if (connecting) watchdog_.excuse(i);
    watchdog_.look(i, watched.worker->ticks(), watched.worker->takeWorstDelay(), now);
  }
  if (watchdog_.allAlive()) sd_notify(0, "WATCHDOG=1");
  for (const Watchdog::News& news : watchdog_.takeNews(now))
    news.is_error ? logError(news.text) : logWarning(news.text);
}

void Supervisor::watchDisks(Timestamp now) {
  for (Stored& stored : stored_) {
    const bool hangs = stored.report(now).waiting > kDiskHangs;
    if (std::exchange(stored.hangs, hangs) == hangs) continue;
    if (!hangs && std::exchange(stored.logged_now, false))
      logInfo(std::string(stored.name) + ": the disk answers again");
    if (!hangs || (stored.logged && now - *stored.logged < kLogInterval)) continue;
    logWarning(std::string(stored.name) + kNoAnswer);
    stored.logged = now;
    stored.logged_now = true;
  }
}

std::string Supervisor::storageWords(Timestamp now) const {
  std::string text;
  for (const Stored& stored : stored_) {
    const StorageReport report = stored.report(now);
    if (!report.problem.empty()) text += std::string("; ") + stored.name + ": " + report.problem;
    if (report.waiting <= kDiskHangs) continue;
    text += std::string("; ") + stored.name + kNoAnswer + " (" +
            std::to_string(std::lround(toSeconds(report.waiting))) + " s so far)";
  }
  return text;
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
  for (WatchedDevice& device : devices_) {
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
