// SPDX-License-Identifier: BSD-3-Clause
#include "app/health_reporter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>

#include "support/wait_until.hpp"
#include "tools/files.hpp"

namespace slam::health_reporter_test {
namespace {

using namespace std::chrono_literals;

TEST(StageHealth, HasThePercentilesOfItsHistogramEachInItsPlace) {
  LatencyHistogram histogram;
  for (int i = 0; i < 98; ++i) histogram.add(100us);
  histogram.add(10ms);
  histogram.add(1s);
  const stage_health_t stage = stageOf("match", histogram);
  EXPECT_EQ(stage.name, "match");
  EXPECT_EQ(stage.count, 100);
  EXPECT_NEAR(stage.p50_us, 100.0, 9.0);
  EXPECT_NEAR(stage.p99_us, 10e3, 900.0);
  EXPECT_NEAR(stage.max_us, 1e6, 1e-3);
}

class Reporter : public testing::Test {
 protected:
  Reporter() { devices.add({"lidar", &lidar, 10.0}); }
  HealthReport sent() {
    HealthReport last{};
    EXPECT_EQ(channels->health.drain([&](const HealthReport& report) { last = report; }), 1U);
    return last;
  }

  const test::Folder folder;
  Config config;
  WallClock clock;
  DeviceStatus lidar;
  std::unique_ptr<Channels> channels = std::make_unique<Channels>();
  DeviceMonitor devices{channels->lidar_stuck};
  HealthReporter reporter{config, clock, devices, channels->health, channels->bus_wakeup};
  const Timestamp start = monotonicNow();
};

TEST_F(Reporter, IsDueOnceASecondAndCatchesNothingUp) {
  reporter.begin(start);
  EXPECT_FALSE(reporter.measure(start + 999ms));
  EXPECT_TRUE(reporter.measure(start + 1s));
  EXPECT_FALSE(reporter.measure(start + 1900ms));
  EXPECT_TRUE(reporter.measure(start + 5s)) << "the process was stopped";
  EXPECT_TRUE(reporter.measure(start + 5100ms)) << "the next one was due now";
  EXPECT_FALSE(reporter.measure(start + 5900ms));
}

TEST_F(Reporter, NamesTheWorstFirst) {
  lidar.set(DeviceState::kAbsent, problem::kPortMissing);
  lidar.countSample(start);
  lidar.identify("an A1");
  reporter.begin(start);
  PoseSnapshot pose;
  pose.pose.state = LocalisationState::kLost;
  pose.counters.wheels_reliable = false;
  pose.counters.scans = 17;
  channels->times.match.add(1ms);
  const Worker thread({.name = "graph", .rate = 20.0}, [] {});
  reporter.send(start + 2s, pose, {{.device = "map", .problem = {problem::kDiskHangs, {7.0}}}},
                {.front_end = &pose.counters, .channels = channels.get(), .threads = {&thread}});
  const auto [problems, health] = sent();
  EXPECT_EQ(
      health.summary,
      "pose lost: no pose is published until the robot is found in the map; waits for the lidar; lidar: no data "
      "for 2.0 s, no such port: check cable and udev rule; the wheels contradict the scans and are not heard; the "
      "disk does not answer; slamd goes on and writes what is new when it does; fix: is it broken, or too slow? (7 "
      "s so far); lidar is an A1");
  std::vector<std::string> ids;
  for (const problem_t& problem : problems.problems) ids.push_back(problem.device + " " + problem.id);
  EXPECT_THAT(ids,
              testing::ElementsAre("pose no_scans", "lidar port_missing", "sensors wheels_rejected", "map disk_hangs"));
  EXPECT_EQ(problems.nproblems, 4);
  EXPECT_EQ(problems.problems[1].level, 2) << "it does not stream";
  EXPECT_EQ(problems.problems[1].cause, "no data for 2.0 s, no such port");
  EXPECT_EQ(problems.problems[1].fix, "check cable and udev rule");
  EXPECT_EQ(problems.problems[3].level, 1);
  EXPECT_EQ(problems.problems[3].numbers.at(0), 7.0);
  EXPECT_EQ(problems.utime, health.utime);
  EXPECT_EQ(health.uptime, 2.0);
  EXPECT_EQ(health.utime, clock.utime(start + 2s));
  EXPECT_EQ(health.localisation, static_cast<std::uint8_t>(LocalisationState::kLost));
  ASSERT_EQ(health.ndevices, 1);
  EXPECT_EQ(health.devices[0].name, "lidar");
  EXPECT_EQ(health.ncounters, std::ssize(health.counters));
  EXPECT_EQ(health.nstages, std::ssize(health.stages));
  std::vector<std::string> stages, counters;
  for (const stage_health_t& stage : health.stages) stages.push_back(stage.name);
  for (const counter_t& counter : health.counters) counters.push_back(counter.name);
  EXPECT_THAT(stages, testing::IsSupersetOf({"graph.work", "graph.late", "match", "scan_to_pose"}));
  EXPECT_THAT(counters, testing::IsSupersetOf({"scans", "graph.ticks", "lcm.published", "drops.scans"}));
}

TEST_F(Reporter, ReportsTheRoomOnTheDisk) {
  config.output.map = folder / "map";
  reporter.begin(start);
  ASSERT_TRUE(test::waitUntil([&] { return !reporter.isBusy(); }));
  reporter.send(start, {}, {}, {});
  EXPECT_GT(sent().health.disk_free_mb, 0.0);
}

}  // namespace
}  // namespace slam::health_reporter_test
