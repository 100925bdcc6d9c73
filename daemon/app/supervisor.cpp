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
// On an overloaded computer a thread waits for others, and for kernel threads of normal priority: reading a serial port
// took up to 3.8 s. Starting slamd anew would not help any of that, it would only end the pose. A dead thread is one
// that waits longer than any of this can last. Until then, what it commands no more is the drives' watchdogs' business.
// Time in which it waits for the CPU is none of that.
constexpr Duration kDead = 10s;
constexpr Duration kConnecting = 12s;      // the lidar's start-up sequence, resets included
constexpr Duration kOptimising = 10s;      // a very large map, on a small computer
constexpr Duration kRealtimeLate = 200ms;  // of a period of 2 to 10 ms
constexpr Duration kReadingLate = 500ms;   // of a wait of 100 ms at most
constexpr Duration kDrawingLate = 2s;      // a large map anew
constexpr Duration kStopLimit = 15s;       // for all at the end; systemd waits for 20 s
constexpr Duration kTurnLimit = 10s;       // of these for the threads' last turn
constexpr Duration kRecordLimit = 3s;      // for the disk, at the end
const char* const kHung = ": the disk has not answered in time";
constexpr Duration kLogWaits = 3s;  // for the disk: nothing is written
constexpr Duration kClockStep = 500ms;
constexpr Duration kPoseWaits = 4s;  // without a pose, before it is logged

/// Runs before the map is loaded: that may take seconds, and a slamd that was killed may have left the wheels turning.
std::unique_ptr<BaseThread> startBase(const Config& config, const BaseEnds& ends) {
  if (!BaseThread::isWanted(config)) return nullptr;
  auto base = std::make_unique<BaseThread>(config, ends);
  base->worker().start();
  return base;
}

}  // namespace

Supervisor::Supervisor(const Config& config)
    : config_(config),
      base_(startBase(config_, channels_.base())),
      graph_(config_, channels_.graph(), clock_),
      estimator_(config_, channels_.estimator(), graph_.firstFrontEnd()),
      mapper_(config_, channels_.mapper(), clock_),
      bus_(config_, channels_.bus(), clock_),
      pose_(config_, channels_.pose(), clock_, bus_.poseSender()),
      devices_(channels_.lidar_stuck),
      watchdog_(kPeriod),
      health_(config_, clock_, devices_, channels_.health, channels_.bus_wakeup) {
  if (config_.lidar_device.isRead()) lidar_ = makeLidarThread(config_, channels_.lidar());

  if (config_.depth_device.driver == DepthDriver::kOpenni2) {
    std::function<std::string()> record_to;
    FieldLog* log = bus_.publisher().fieldLog();
    if (log != nullptr && config_.log.images && config_.depth_device.record.empty())
      record_to = [log] { return log->imagesPath(); };
    depth_ = makeDepthThread(config_, channels_.depth(), std::move(record_to));
  }
  watchDevices();
  watchThreads();

  storage_.add("map", [this](Timestamp now) { return graph_.jobs().report(now); });
  storage_.add("map files", [this](Timestamp now) { return mapper_.storage(now); });
  if (Recorder* recorder = bus_.publisher().recorder()) {
    storage_.add("record", [recorder](Timestamp now) { return recorder->report(now); });
  }
  if (Recorder* log = bus_.publisher().logRecorder())
    storage_.add("log", [log](Timestamp now) { return log->report(now); });
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
  SensorReceiver& sensors = bus_.sensors();
  if (lidar_) add(lidar, &lidar_->driver().status(), kLidarRate);
  if (config_.lidar_device.driver == LidarDriver::kLcm) addOverLcm(lidar, sensors.lidarStatus());
  if (base_ && base_->wheelStatus()) add(base, base_->wheelStatus(), base_->wheelRate());
  if (config_.base_device.driver == BaseDriver::kLcm) addOverLcm(base, sensors.wheelStatus());
  if (base_ && base_->imuStatus()) add(imu, base_->imuStatus(), base_->imuRate());
  if (config_.imu_device.driver == ImuDriver::kLcm) addOverLcm(imu, sensors.imuStatus());
  if (depth_) add(depth, &depth_->driver().status(), static_cast<double>(config_.depth_device.rate));
  if (config_.depth_device.driver == DepthDriver::kLcm) addOverLcm(depth, sensors.depthStatus());
}

void Supervisor::watchThreads() {
  watchdog_.add(estimator_.worker(), {kRealtimeLate, kDead});
  // The pose needs neither of these two: they are not worth its end.
  watchdog_.add(graph_.worker(),
                {.late = kOptimising, .dead = kOptimising + kDead, .vital = false, .death = &problem::kGraphDead});
  watchdog_.add(mapper_.worker(),
                {.late = kDrawingLate, .dead = kDrawingLate + kDead, .vital = false, .death = &problem::kMapperDead});
  watchdog_.add(bus_.worker(), {kReadingLate, kDead});
  watchdog_.add(pose_.worker(), {kReadingLate, kDead});
  if (base_) watchdog_.add(base_->worker(), {kRealtimeLate, kDead});
  if (lidar_) watchdog_.add(lidar_->worker(), {kReadingLate, kConnecting + kDead}, &lidar_->driver().status());
  if (depth_)  // OpenNI2's calls may hang
    watchdog_.add(depth_->worker(),
                  {.late = kReadingLate, .dead = kConnecting, .vital = false, .death = &problem::kCameraDead},
                  &depth_->driver().status());
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
    if (not_locked_) logWarning(not_locked_.words());
  }
  // What the base has measured while the map was loaded has gaps, its queues were full, and it counts for no rate.
  for (auto* sensors : {&channels_.samples, &channels_.raw}) {
    sensors->wheels.drain([](const WheelReading&) {});
    sensors->imu.drain([](const ImuSample&) {});
  }
  health_.begin(monotonicNow());
  for (Worker* worker : watchdog_.workers()) {
    if (!base_ || worker != &base_->worker()) worker->start();
  }
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
    watchdog_.look(now);
    devices_.setOverloaded(watchdog_.isOverloaded(now));
    const std::vector<Trouble> others = otherTroubles(now);
    bool news = devices_.look(now);
    news |= std::exchange(link_seen_, bus_.publisher().linkState()) != bus_.publisher().linkState();
    devices_.setEchoes(snapshot_.echo_finding);
    log(others, now);
    const bool due = health_.measure(now);  // news does not wait
    if (due || news) health_.send(now, snapshot_, withThreads(others, now), counted());
  }
  const bool saved = stop();
  if (graph_.jobs().isWriting() || mapper_.isWriting() || recorder_hangs_ || thread_hangs_ || health_.isBusy()) {
    std::_Exit(saved ? 0 : 1);  // a thread that waits for a disk, or never ends its turn, cannot be joined
  }
  return saved ? 0 : 1;
}

/// @return whether it has ended
bool Supervisor::end(Worker& worker, Timestamp deadline) {
  if (worker.stop(deadline)) return true;
  logError("thread " + worker.name() +
           " does not end its turn; slamd ends without it, and what it has not stored is lost");
  thread_hangs_ = true;
  return false;
}

bool Supervisor::stop() {
  const Timestamp begin = monotonicNow(), turns = begin + kTurnLimit, last = begin + kStopLimit;
  sd_notify(0, "STOPPING=1");
  logInfo("stopping");
  for (Worker* worker : watchdog_.workers()) worker->requestStop();  // all at once, then wait for each
  if (base_) base_->stop();  // first: another thread may take long, and the wheels must not turn meanwhile
  for (Worker* worker : watchdog_.workers()) {
    if (worker != &mapper_.worker()) end(*worker, turns);
  }
  if (lidar_) lidar_->driver().stop();
  if (depth_) depth_->driver().stop();
  // Nobody else may touch what a thread that never ended its turn is at.
  const bool graph = graph_.worker().stop(turns), mapper = end(mapper_.worker(), turns);
  const Timestamp now = monotonicNow();
  if (graph) graph_.finish();
  if (mapper) mapper_.finish();
  if (graph && mapper) graph_.jobs().store(mapper_.drawn());
  for (Recorder* recorder : {bus_.publisher().recorder(), bus_.publisher().logRecorder()}) {
    if (recorder == nullptr) continue;
    if (!recorder->finish(now + kRecordLimit)) {
      const StorageReport left = recorder->report(now);
      logError("the " + recorder->name() + "'s end is lost: the disk has not taken it" +
               (left.problem.problem ? "; " + left.problem.words() : "") + (left.lost ? "; " + left.lost.words() : ""));
    }
    recorder_hangs_ |= recorder->report(monotonicNow()).waiting > Duration(0);
  }
  if (bus_.publisher().fieldLog() != nullptr)
    recorder_hangs_ |= bus_.publisher().fieldLog()->keeperHangs(now + kRecordLimit);
  const bool drawn = mapper && mapper_.waitUntilSaved(last),
             stored = graph && mapper && graph_.jobs().waitUntilStored(last);
  if (!graph || !mapper) return false;
  if (!drawn) logError("the map files are not saved" + std::string(mapper_.isWriting() ? kHung : ""));
  if (!stored)
    logError("the map is not stored" + std::string(graph_.jobs().isWriting() ? kHung : "") + ": " +
             graph_.jobs().loss());
  return drawn && stored;
}

void Supervisor::log(const std::vector<Trouble>& others, Timestamp now) {
  logLines(devices_.arrivals(log_, now));
  std::vector<Trouble> all = devices_.troubles(now);
  for (const auto& troubles : {poseTroubles(now), sensorTroubles(snapshot_), others})
    all.insert(all.end(), troubles.begin(), troubles.end());
  logLines(log_.look(all, now));
  if (bus_.publisher().linkState() == LinkState::kConnected && !std::exchange(link_worked_, true))
    logInfo("LCM connected: " + bus_.url().text);
  const bool localised = snapshot_.pose.state == LocalisationState::kLocalised;
  if (localised && !std::exchange(localised_, true) && !log_.isOpen("pose")) logInfo("pose localised");
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

std::vector<Trouble> Supervisor::poseTroubles(Timestamp now) {
  const LocalisationState state = snapshot_.pose.state;
  if (state == LocalisationState::kLocalised) return unlocalised_since_.reset(), std::vector<Trouble>{};
  if (!unlocalised_since_) unlocalised_since_ = now;
  // Every drive begins without a pose, and single scans do not match.
  const bool matters = state == LocalisationState::kLost || now - *unlocalised_since_ >= kPoseWaits;
  Trouble trouble = poseTrouble(snapshot_, devices_.streams("lidar", now));
  if (!matters) trouble.problem = {};
  return {trouble};
}

/// All but devices, sensors and pose, which health shows in its own words.
std::vector<Trouble> Supervisor::otherTroubles(Timestamp now) const {
  std::vector<Trouble> troubles = storage_.troubles(now);
  if (const Problem settings = base_ ? base_->finding() : Problem())
    troubles.push_back({.device = "base", .problem = settings, .besides = true});
  if (const Problem link = problemOf(bus_.publisher().linkState(), bus_.url()))
    troubles.push_back({.device = "LCM", .problem = link, .begin = "LCM: ", .recovery = "LCM messages are sent again"});
  if (const Duration ahead = -clock_.drift(); ahead > kClockStep)
    troubles.push_back({.device = "clock set back",
                        .problem = {problem::kClockBack, {toSeconds(ahead)}},
                        .recovery = "the wall clock has reached the stamps"});
  if (bus_.publisher().hasRival())
    troubles.push_back({.device = "SLAM_POSE",
                        .problem = {problem::kRival, {}, {config_.lcm.url}},
                        .begin = "LCM: ",
                        .recovery = "LCM: SLAM_POSE is ours alone again",
                        .fault = true});
  if (const Problem drive = bus_.driveProblem())
    troubles.push_back({.device = "SLAM_DRIVE", .problem = drive, .recovery = "SLAM_DRIVE is obeyed again"});
  if (const Problem socket = bus_.socketProblem())
    troubles.push_back(
        {.device = "socket", .problem = socket, .recovery = config_.runtime.socket + ": commands are taken again"});
  return troubles;
}

/// The log has lines of its own about these.
std::vector<Trouble> Supervisor::withThreads(std::vector<Trouble> troubles, Timestamp now) const {
  for (const Problem& problem : watchdog_.problems(now)) troubles.push_back({.device = "threads", .problem = problem});
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
  all.threads.assign(watchdog_.workers().begin(), watchdog_.workers().end());
  for (const WatchedDevice& device : devices_.devices()) all.devices.emplace_back(device.name, device.status);
  for (const Recorder* recorder : {bus_.publisher().recorder(), bus_.publisher().logRecorder()}) {
    if (recorder != nullptr) all.recorders.emplace_back(recorder->name(), &recorder->counters());
  }
  if (base_) all.battery = base_->battery();
  if (base_ && config_.base_device.speed_commands) all.limited_speeds = base_->limitedSpeeds();
  if (base_ && base_->usesCan()) all.can = &can_counters_;
  all.echoes = snapshot_.echoes;
  if (const FieldLog* log = bus_.publisher().fieldLog()) {
    const StorageReport report = bus_.publisher().logRecorder()->report(monotonicNow());
    const bool fails = report.problem.problem || report.waiting > kLogWaits;
    all.logs = !log->isRunning() ? kLogStopped : fails ? kLogFails : kLogWritten;
  }
  return all;
}

}  // namespace slam
