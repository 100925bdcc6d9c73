// SPDX-License-Identifier: BSD-3-Clause
#include "app/counters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <set>

#include "app/health_reporter.hpp"
#include "build_paths.hpp"
#include "tools/files.hpp"

namespace slam::counters_test {
namespace {

/// One more element than a queue has room for, and so many more.
template <typename T>
void overfill(SpscQueue<T>& queue, int drops) {
  const auto element = std::make_unique<T>();
  while (queue.tryPush(*element)) continue;
  for (int i = 1; i < drops; ++i) queue.tryPush(*element);
}

/// [bytes] of a struct that its visitor leaves out.
template <typename Counters>
std::size_t notVisited(const Counters& counters) {
  std::size_t rest = sizeof counters;
  const auto visit = [&](const CounterInfo&, const auto& value) { rest -= sizeof value; };
  if constexpr (std::is_same_v<Counters, RecorderCounters>) {
    visitCounters(counters, "record", visit);
  } else {
    visitCounters(counters, visit);
  }
  return rest;
}

TEST(Counters, AreAllVisited) {
  EXPECT_LT(notVisited(FrontEndCounters{}), 8U) << "one bool is no counter";
  EXPECT_EQ(notVisited(EkfCounters{}), 0U);
  EXPECT_EQ(notVisited(BackEndCounters{}), 0U);
  EXPECT_EQ(notVisited(CanLinkCounters{}), 0U);
  EXPECT_EQ(notVisited(BusCounters{}), 0U);
  EXPECT_EQ(notVisited(RecorderCounters{}), 0U);
  std::size_t stages = 0;
  visitStages(StageTimes{}, [&](const char*, const LatencyHistogram&) { ++stages; });
  EXPECT_EQ(stages * sizeof(LatencyHistogram), sizeof(StageTimes));
}

TEST(Counters, AreDescribedEachOnce) {
  const FrontEndCounters front_end;
  const EkfCounters filter;
  const BackEndCounters back_end;
  const auto channels = std::make_unique<Channels>();
  const CanLinkCounters can;
  const Counted all{
      .front_end = &front_end, .filter = &filter, .back_end = &back_end, .channels = channels.get(), .can = &can};
  std::set<std::string> names, statistics;
  const auto look = [&](const CounterInfo& what, const auto&) {
    EXPECT_TRUE(names.insert(what.name).second) << what.name;
    EXPECT_TRUE(statistics.insert(what.statistic()).second) << what.statistic();
    EXPECT_FALSE(what.unit.empty()) << what.name;
    EXPECT_TRUE(what.meaning.ends_with(".")) << what.name;
  };
  visitPipelineCounters(all, look);
  visitDaemonCounters(all, look);
}

TEST(Counters, AreThoseOfTheDocument) {
  EXPECT_TRUE(test::contentOf(SLAMD_SOURCE_DIR "/docs/counters.md") == printCounters())
      << "write it anew: slamd --print-counters > docs/counters.md";
}

/// Names that are published are an interface: none may vanish, or change what it counts.
TEST(Counters, CarryEachItsOwnValue) {
  const auto channels = std::make_unique<Channels>();
  std::map<std::string, std::int64_t> expected;
  std::int64_t next = 100;
  const auto set = [&](const char* name, auto& value) {
    expected[name] = ++next;
    value = static_cast<std::uint32_t>(next);
  };
  FrontEndCounters l;
  set("scans", l.scans), set("scans.matched", l.matched), set("scans.partly_observable", l.partly_observable);
  set("scans.unmatched", l.unmatched), set("scans.gated", l.gated), set("scans.held", l.scans_held);
  set("scans.retimed", l.scans_retimed), set("scans.too_late", l.scans_too_late);
  set("scans.repeated", l.scans_repeated), set("clock_resets", l.clock_resets), set("samples.far_ahead", l.far_ahead);
  set("wheels.rejected", l.wheels_rejected), set("gyro.rejected", l.gyro_rejected), set("keyframes", l.keyframes),
      set("scans.searched", l.searched);
  set("lost", l.lost), set("samples.late", l.samples_late), set("samples.too_old", l.samples_too_old);
  set("views", l.views), set("views.unplaced", l.views_unplaced);
  expected["wheels.withdrawn"] = expected["wheels.rejected"];
  l.wheels_scale = 1.0316;
  expected["wheels.scale_permille"] = 1032;
  EkfCounters f;
  set("ekf.wheels_rejected", f.wheels_rejected), set("ekf.gyro_rejected", f.gyro_rejected);
  set("ekf.poses_rejected", f.poses_rejected), set("ekf.standstill_updates", f.standstill_updates);
  BackEndCounters g;
  set("loop_closures", g.loop_closures), set("loop_closures.revoked", g.revoked);
  set("relocalised", g.placed), set("maps.begun_anew", g.begun_anew);
  BusCounters& b = channels->bus_counters;
  set("lcm.published", b.published), set("lcm.failures", b.failures), set("lcm.bad_messages", b.bad_messages);
  set("lcm.fragments", b.fragments), set("lcm.other_packets", b.other_packets), set("lcm.dropped", b.dropped);
  set("socket.clients", b.socket_clients), set("socket.bad_packets", b.socket_bad);
  set("socket.dropped_clients", b.socket_dropped), set("socket.refused_clients", b.socket_refused);
  overfill(channels->samples.scans, 1), overfill(channels->samples.wheels, 2), overfill(channels->samples.imu, 3);
  overfill(channels->samples.views, 4), overfill(channels->front_end.sights, 5),
      overfill(channels->front_end.keyframes, 6);
  expected["drops.scans"] = 1, expected["drops.wheels"] = 2, expected["drops.imu"] = 3;
  expected["drops.views"] = 4, expected["drops.sights"] = 5, expected["drops.keyframes"] = 6;
  CanLinkCounters can;
  set("can.received", can.received), set("can.queue_full", can.queue_full), set("can.bus_offs", can.bus_offs);
  DeviceStatus lidar;
  set("lidar.thinned", lidar.thinned);
  RecorderCounters record;
  set("record.written", record.written), set("record.dropped", record.dropped);
  expected["base.battery_mv"] = 11500, expected["log.running"] = 1;
  const Worker thread({.name = "estimator", .rate = 1.0}, [] {});
  for (const char* name : {"estimator.ticks", "estimator.overruns", "estimator.cpu_ms"}) expected[name] = 0;
  const Counted all{.front_end = &l,
                    .filter = &f,
                    .back_end = &g,
                    .channels = channels.get(),
                    .threads = {&thread},
                    .devices = {{"lidar", &lidar}},
                    .can = &can,
                    .recorders = {{"record", &record}},
                    .battery = 11.5F,
                    .logs = kLogWritten};
  std::map<std::string, std::int64_t> counters;
  const auto add = [&](const CounterInfo& what, const auto& value) {
    const counter_t counter = counterOf(what, value);
    counters[counter.name] = counter.value;
  };
  visitPipelineCounters(all, add);
  visitDaemonCounters(all, add);
  for (const auto& [name, value] : expected) EXPECT_THAT(counters, testing::Contains(testing::Pair(name, value)));
}

TEST(Stages, CarryEachItsOwnTimes) {
  StageTimes times;
  int count = 0;
  for (LatencyHistogram* histogram :
       {&times.match, &times.scan_work, &times.scan_to_pose, &times.depth, &times.map, &times.loop_closure}) {
    ++count;
    for (int i = 0; i < count; ++i) histogram->add(std::chrono::milliseconds(1));
  }
  std::map<std::string, std::int64_t> counts;
  visitStages(times, [&](const char* name, const LatencyHistogram& t) { counts[name] = stageOf(name, t).count; });
  EXPECT_THAT(counts, testing::ElementsAre(testing::Pair("depth", 4), testing::Pair("loop_closure", 6),
                                           testing::Pair("map", 5), testing::Pair("match", 1),
                                           testing::Pair("scan_to_pose", 3), testing::Pair("scan_work", 2)));
}

}  // namespace
}  // namespace slam::counters_test
