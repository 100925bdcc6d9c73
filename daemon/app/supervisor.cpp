// SPDX-License-Identifier: BSD-3-Clause
#include "app/supervisor.hpp"

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <string_view>
#include <systemd/sd-daemon.h>
#include <tuple>
#include <utility>

#include "app/log/log.hpp"
#include "app/pose_problem.hpp"
#include "drivers/udev_links.hpp"
#include "runtime/realtime.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kPeriod = 100ms;
constexpr Duration kLogWaits = 3s;  // for the disk: nothing is written
constexpr Duration kClockStep = 500ms;

}  // namespace

Supervisor::Supervisor(const Config& config)
    : config_(config),
      threads_(config_, channels_, clock_, kPeriod),
      devices_(channels_.lidar_stuck),
      health_(config_, clock_, devices_, channels_.health, channels_.bus_wakeup) {
  watchDevices();
  storage_.add("map", [this](Timestamp now) { return threads_.graph().jobs().report(now); });
  storage_.add("map files", [this](Timestamp now) { return threads_.mapper().storage(now); });
  const Publisher& publisher = threads_.bus().publisher();
  if (Recorder* recorder = publisher.recorder())
    storage_.add("record", [recorder](Timestamp now) { return recorder->report(now); });
  if (Recorder* log = publisher.logRecorder()) storage_.add("log", [log](Timestamp now) { return log->report(now); });
}

/// The devices, and what slamd does without each of them.
void Supervisor::watchDevices() {
  constexpr double kLidarRate = 5.5, kLcmRate = 0.0;  // [Hz] 0: whatever comes
  const bool has_lidar = config_.lidar_device.driver != LidarDriver::kNone,
             has_imu = config_.imu_device.driver != ImuDriver::kNone;
  const WatchedDevice lidar{
      .name = "lidar", .without = has_imu ? "goes on by wheels and IMU" : "goes on by the wheels", .by = "base"};
  const WatchedDevice base{
      .name = "base", .without = has_lidar ? "goes on by scan matching" : "goes on without motion", .by = "lidar"};
  const WatchedDevice imu{.name = "imu", .without = "takes the turn rate from the wheels", .by = "base"};
  const WatchedDevice depth{.name = "depth", .without = "draws what the lidar sees alone"};
  const auto add = [this](WatchedDevice device, DeviceStatus* status, double expected) {
    device.status = status;
    device.expected = expected;
    devices_.add(device);
  };
  const auto addOverLcm = [&](WatchedDevice device, DeviceStatus& status) {
    device.over_lcm = true;
    add(device, &status, kLcmRate);
  };
  SensorReceiver& sensors = threads_.bus().sensors();
  if (threads_.lidar()) add(lidar, &threads_.lidar()->driver().status(), kLidarRate);
  if (config_.lidar_device.driver == LidarDriver::kLcm) addOverLcm(lidar, sensors.lidarStatus());
  if (threads_.base() && threads_.base()->wheelStatus())
    add(base, threads_.base()->wheelStatus(), threads_.base()->wheelRate());
  if (config_.base_device.driver == BaseDriver::kLcm) addOverLcm(base, sensors.wheelStatus());
  if (threads_.base() && threads_.base()->imuStatus())
    add(imu, threads_.base()->imuStatus(), threads_.base()->imuRate());
  if (config_.imu_device.driver == ImuDriver::kLcm) addOverLcm(imu, sensors.imuStatus());
  if (threads_.depth())
    add(depth, &threads_.depth()->driver().status(), static_cast<double>(config_.depth_device.rate));
  if (config_.depth_device.driver == DepthDriver::kLcm) addOverLcm(depth, sensors.depthStatus());
}

Supervisor::~Supervisor() { threads_.stopWheels(); }  // before the others are joined, which may take long

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
    if (not_locked_) logWarning(not_locked_.words());
  }
  // What the base has measured while the map was loaded has gaps, its queues were full, and it counts for no rate.
  for (auto* sensors : {&channels_.samples, &channels_.raw}) {
    sensors->wheels.drain([](const WheelReading&) {});
    sensors->imu.drain([](const ImuSample&) {});
  }
  health_.begin(monotonicNow());
  threads_.start();
  sd_notify(0, "READY=1");
  logClaimants();
  logInfo("running, version " SLAMD_VERSION);
}

void Supervisor::logClaimants() const {
  const bool lidar = config_.lidar_device.isRead(), board = config_.base_device.isSerial();
  const bool imu = config_.imu_device.isSerial();
  for (const auto& [used, key, port] : {std::tuple(lidar, "lidar", config_.lidar_device.port),
                                        {board, "base", config_.base_device.port},
                                        {imu, "imu", config_.imu_device.port}}) {
    const auto claimants = used ? claimantsOf(port) : std::vector<Claimant>{};
    if (const std::string words = describeClaimants(port, claimants); !words.empty())
      logWarning(std::string(key) + ": " + words + ", slamd opens it all the same; set " + key +
                 ".port to a name that stays with the USB socket: " + claimants.front().by_path + " or " +
                 claimants.back().by_path);
  }
}

int Supervisor::run() {
  start();
  const sigset_t signals = stopSignals();
  const timespec period{0, static_cast<long>(kPeriod.count())};
  while (sigtimedwait(&signals, nullptr, &period) < 0) {
    const Timestamp now = monotonicNow();
    channels_.pose_for_supervisor.load(snapshot_);
    threads_.watchdog().look(now);
    devices_.setOverloaded(threads_.watchdog().isOverloaded(now));
    const std::vector<Trouble> others = otherTroubles(now);
    bool news = devices_.look(now);
    news |= std::exchange(link_seen_, threads_.bus().publisher().linkState()) != threads_.bus().publisher().linkState();
    devices_.setEchoes(snapshot_.echo_finding);
    log(others, now);
    const bool due = health_.measure(now);  // news does not wait
    if (due || news) health_.send(now, snapshot_, withThreads(others, now), counted());
  }
  const bool saved = threads_.stop();
  // A thread that waits for a disk, or never ends its turn, cannot be joined.
  if (threads_.hang() || health_.isBusy()) std::_Exit(saved ? 0 : 1);
  return saved ? 0 : 1;
}

void Supervisor::log(const std::vector<Trouble>& others, Timestamp now) {
  logLines(devices_.arrivals(log_, now));
  std::vector<Trouble> all = devices_.troubles(now);
  for (const auto& troubles :
       {pose_watch_.troubles(snapshot_, devices_.streams("lidar", now), now), sensorTroubles(snapshot_), others})
    all.insert(all.end(), troubles.begin(), troubles.end());
  logLines(log_.look(all, now));
  if (threads_.bus().publisher().linkState() == LinkState::kConnected && !std::exchange(link_worked_, true))
    logInfo("LCM connected: " + threads_.bus().url().text);
  if (pose_watch_.isFirst(snapshot_) && !log_.isOpen("pose")) logInfo("pose localised");
  followClock(now);
}

/// A utime that was given is never given again: a clock that is set ahead is followed, one that is set back is not.
void Supervisor::followClock(Timestamp now) {
  const Duration step = clock_.drift();
  if (step <= kClockStep) return;
  clock_.follow(step);
  const Problem problem(problem::kClockAhead, {toSeconds(step)});
  if (const auto line = log_.happened("clock", problem, problem.words(), LogLine::kWarning, now)) logLine(*line);
}

/// All but devices, sensors and pose, which health shows in its own words.
std::vector<Trouble> Supervisor::otherTroubles(Timestamp now) const {
  std::vector<Trouble> troubles = storage_.troubles(now);
  if (const Problem doubt = threads_.graph().jobs().floorDoubt())
    troubles.push_back({.device = "map", .problem = doubt, .begin = "map: ", .besides = true});
  if (const Problem settings = threads_.base() ? threads_.base()->finding() : Problem())
    troubles.push_back({.device = "base", .problem = settings, .besides = true});
  if (const Problem link = problemOf(threads_.bus().publisher().linkState(), threads_.bus().url()))
    troubles.push_back({.device = "LCM", .problem = link, .begin = "LCM: ", .recovery = "LCM messages are sent again"});
  if (const Duration ahead = -clock_.drift(); ahead > kClockStep)
    troubles.push_back({.device = "clock set back",
                        .problem = {problem::kClockBack, {toSeconds(ahead)}},
                        .recovery = "the wall clock has reached the stamps"});
  if (threads_.bus().publisher().hasRival())
    troubles.push_back({.device = "SLAM_POSE",
                        .problem = {problem::kRival, {}, {config_.lcm.url}},
                        .begin = "LCM: ",
                        .recovery = "LCM: SLAM_POSE is ours alone again",
                        .fault = true});
  if (const Problem drive = threads_.bus().driveProblem())
    troubles.push_back({.device = "SLAM_DRIVE", .problem = drive, .recovery = "SLAM_DRIVE is obeyed again"});
  if (const Problem socket = threads_.bus().socketProblem())
    troubles.push_back(
        {.device = "socket", .problem = socket, .recovery = config_.runtime.socket + ": commands are taken again"});
  return troubles;
}

/// The log has lines of its own about these.
std::vector<Trouble> Supervisor::withThreads(std::vector<Trouble> troubles, Timestamp now) const {
  for (const Problem& problem : threads_.watchdog().problems(now))
    troubles.push_back({.device = "threads", .problem = problem});
  if (not_locked_) troubles.push_back({.device = "memory", .problem = not_locked_});
  return troubles;
}

Counted Supervisor::counted() {
  channels_.graph_counters.load(graph_counters_);
  channels_.can_counters.load(can_counters_);
  Counted all{.front_end = &snapshot_.counters,
              .filter = &snapshot_.filter,
              .back_end = &graph_counters_,
              .channels = &channels_};
  all.threads.assign(threads_.watchdog().workers().begin(), threads_.watchdog().workers().end());
  for (const WatchedDevice& device : devices_.devices()) all.devices.emplace_back(device.name, device.status);
  for (const Recorder* recorder : threads_.recorders())
    all.recorders.emplace_back(recorder->name(), &recorder->counters());
  if (threads_.base()) all.battery = threads_.base()->battery();
  if (threads_.base() && config_.base_device.speed_commands) all.limited_speeds = threads_.base()->limitedSpeeds();
  if (threads_.base() && threads_.base()->usesCan()) all.can = &can_counters_;
  all.echoes = snapshot_.echoes;
  if (const FieldLog* log = threads_.bus().publisher().fieldLog()) {
    const StorageReport report = threads_.bus().publisher().logRecorder()->report(monotonicNow());
    const bool fails = report.problem.problem || report.waiting > kLogWaits;
    all.logs = !log->isRunning() ? kLogStopped : fails ? kLogFails : kLogWritten;
  }
  return all;
}

}  // namespace slam
