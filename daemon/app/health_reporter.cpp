// SPDX-License-Identifier: BSD-3-Clause
#include "app/health_reporter.hpp"

#include <algorithm>
#include <systemd/sd-daemon.h>
#include <utility>

#include "app/pose_problem.hpp"
#include "bus/problem_message.hpp"
#include "diagnostics/sensor_problems.hpp"
#include "problems/daemon.hpp"
#include "runtime/process_usage.hpp"

namespace slam {
namespace {

constexpr Duration kPeriod = std::chrono::seconds(1);
constexpr Duration kSettled = std::chrono::seconds(5);  // from the start: then rates are judged

constexpr std::size_t kMostProblems = 24;  // that certainly fit into a datagram

problems_t messageOf(const std::vector<Trouble>& troubles, std::int64_t utime) {
  problems_t message{};
  message.utime = utime;
  for (const Trouble& trouble : troubles) {
    if (message.problems.size() == kMostProblems) break;
    problem_t entry = toMessage(trouble.device, trouble.problem, trouble.fault);
    entry.cause = trouble.since + entry.cause;
    if (entry.meanwhile.empty()) entry.meanwhile = trouble.meanwhile;
    message.problems.push_back(std::move(entry));
  }
  message.nproblems = static_cast<std::int32_t>(message.problems.size());
  return message;
}

}  // namespace

std::vector<Trouble> sensorTroubles(const PoseSnapshot& pose) {
  std::vector<Trouble> troubles;
  for (const SensorFinding& finding : pose.findings.all())
    troubles.push_back({.device = "sensors", .problem = problemOf(finding), .besides = true});
  if (!pose.counters.wheels_reliable)
    troubles.push_back({.device = "sensors", .problem = problem::kWheelsRejected, .besides = true});
  return troubles;
}

stage_health_t stageOf(const std::string& name, const LatencyHistogram& histogram) {
  const auto summary = histogram.summary();
  stage_health_t s{};
  s.name = name;
  s.count = summary.count;
  s.p50_us = summary.p50_us;
  s.p99_us = summary.p99_us;
  s.max_us = summary.max_us;
  return s;
}

void HealthReporter::begin(Timestamp now) {
  started_ = measured_ = now;
  next_ = now + kPeriod;
  devices_.begin();
  measureDiskSpace();
}

bool HealthReporter::measure(Timestamp now) {
  if (now < next_) return false;
  next_ = std::max(next_ + kPeriod, now);
  const double interval = toSeconds(now - std::exchange(measured_, now)), cpu = cpuSeconds();
  measureDiskSpace();
  cpu_share_ = (cpu - std::exchange(cpu_, cpu)) / interval;
  devices_.measureRates(interval, now - started_ > kSettled, now);
  return true;
}

void HealthReporter::measureDiskSpace() {
  if (!disk_space_.isBusy()) disk_space_.start([this] { disk_free_ = diskFree(); });
}

double HealthReporter::diskFree() const {
  const std::string &maps = config_.store.directory, &log = config_.log.directory;
  double least = -1.0;
  for (const std::string& file : {maps.empty() ? maps : maps + "/map", config_.output.map, config_.output.record,
                                  config_.depth_device.record, log.empty() ? log : log + "/run"}) {
    const double free = file.empty() ? -1.0 : diskFreeMegabytes(file);
    if (free >= 0.0) least = least < 0.0 ? free : std::min(least, free);
  }
  return least;
}

void HealthReporter::send(Timestamp now, const PoseSnapshot& pose, const std::vector<Trouble>& others,
                          const Counted& counted) {
  const Trouble waits = poseTrouble(pose, devices_.streams("lidar", now));
  std::vector<Trouble> all = devices_.problems(now);
  for (const auto& more : {sensorTroubles(pose), others}) all.insert(all.end(), more.begin(), more.end());
  HealthReport report{};
  health_t& health = report.health;
  health.utime = clock_.utime(now);
  health.uptime = toSeconds(now - started_);
  health.localisation = static_cast<std::uint8_t>(pose.pose.state);
  health.summary = waits.text();
  for (const Trouble& trouble : all) health.summary += "; " + trouble.text();
  health.summary += devices_.identities();
  if (waits.problem) all.insert(all.begin(), waits);
  report.problems = messageOf(all, health.utime);
  health.cpu = cpu_share_;
  health.memory_mb = residentMegabytes();
  health.disk_free_mb = disk_free_;
  health.devices = devices_.health(now);
  const auto add_stage = [&](const std::string& name, const LatencyHistogram& histogram) {
    health.stages.push_back(stageOf(name, histogram));
  };
  for (const Worker* thread : counted.threads) {
    add_stage(thread->name() + ".work", thread->duration());
    if (thread->rate() > 0.0) add_stage(thread->name() + ".late", thread->lateness());
  }
  if (counted.channels != nullptr) visitStages(counted.channels->times, add_stage);
  const auto add_counter = [&](const CounterInfo& what, const auto& value) {
    health.counters.push_back(counterOf(what, value));
  };
  visitDaemonCounters(counted, add_counter);
  visitPipelineCounters(counted, add_counter);
  health.ndevices = static_cast<std::int32_t>(health.devices.size());
  health.nstages = static_cast<std::int32_t>(health.stages.size());
  health.ncounters = static_cast<std::int32_t>(health.counters.size());
  messages_.tryPush(report);
  bus_wakeup_.notify();
  sd_notify(0, ("STATUS=" + health.summary).c_str());
}

}  // namespace slam
