// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/daemon_threads.hpp"

#include <chrono>
#include <systemd/sd-daemon.h>
#include <utility>

#include "app/log/log.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
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

/// Runs before the map is loaded: that may take seconds, and a slamd that was killed may have left the wheels turning.
std::unique_ptr<BaseThread> startBase(const Config& config, const BaseEnds& ends) {
  if (!BaseThread::isWanted(config)) return nullptr;
  auto base = std::make_unique<BaseThread>(config, ends);
  base->worker().start();
  return base;
}

}  // namespace

DaemonThreads::DaemonThreads(const Config& config, Channels& channels, WallClock& clock, Duration look)
    : base_(startBase(config, channels.base())),
      graph_(config, channels.graph(), clock),
      estimator_(config, channels.estimator(), graph_.firstFrontEnd()),
      mapper_(config, channels.mapper(), clock),
      bus_(config, channels.bus(), clock),
      pose_(config, channels.pose(), clock, bus_.poseSender()),
      watchdog_(look) {
  if (config.lidar_device.isRead()) lidar_ = makeLidarThread(config, channels.lidar());

  if (config.depth_device.driver == DepthDriver::kOpenni2) {
    std::function<std::string()> record_to;
    FieldLog* log = bus_.publisher().fieldLog();
    if (log != nullptr && config.log.images && config.depth_device.record.empty())
      record_to = [log] { return log->imagesPath(); };
    depth_ = makeDepthThread(config, channels.depth(), std::move(record_to));
  }
  watchThreads();
}

void DaemonThreads::watchThreads() {
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

void DaemonThreads::start() {
  for (Worker* worker : watchdog_.workers()) {
    if (!base_ || worker != &base_->worker()) worker->start();
  }
}

std::vector<Recorder*> DaemonThreads::recorders() const {
  std::vector<Recorder*> all{bus_.publisher().recorder(), bus_.publisher().logRecorder()};
  std::erase(all, nullptr);
  return all;
}

/// @return whether it has ended
bool DaemonThreads::end(Worker& worker, Timestamp deadline) {
  if (worker.stop(deadline)) return true;
  logError("thread " + worker.name() +
           " does not end its turn; slamd ends without it, and what it has not stored is lost");
  hangs_ = true;
  return false;
}

bool DaemonThreads::stop() {
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
  for (Recorder* recorder : recorders()) {
    if (!recorder->finish(now + kRecordLimit)) {
      const StorageReport left = recorder->report(now);
      logError("the " + recorder->name() + "'s end is lost: the disk has not taken it" +
               (left.problem.problem ? "; " + left.problem.words() : "") + (left.lost ? "; " + left.lost.words() : ""));
    }
    hangs_ |= recorder->report(monotonicNow()).waiting > Duration(0);
  }
  if (bus_.publisher().fieldLog() != nullptr) hangs_ |= bus_.publisher().fieldLog()->keeperHangs(now + kRecordLimit);
  const bool drawn = mapper && mapper_.waitUntilSaved(last),
             stored = graph && mapper && graph_.jobs().waitUntilStored(last);
  if (!graph || !mapper) return false;
  if (!drawn) logError("the map files are not saved" + std::string(mapper_.isWriting() ? kHung : ""));
  if (!stored)
    logError("the map is not stored" + std::string(graph_.jobs().isWriting() ? kHung : "") + ": " +
             graph_.jobs().loss());
  return drawn && stored;
}

}  // namespace slam
