// SPDX-License-Identifier: BSD-3-Clause
#include "app/health_parts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <memory>

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kNow{1000s};

/// A lidar of 10 Hz whose driver streams.
struct Lidar {
  DeviceStatus status;
  WatchedDevice device{"lidar", &status, 10.0};

  Lidar() { status.set(DeviceState::kStreaming, ""); }
  std::string reason(Timestamp now = kNow) const { return reasonOf(device, status.reason.load(), now); }
  /// Samples of the second that ends now.
  void measure(int samples, Timestamp now = kNow, bool settled = true) {
    for (int i = 0; i < samples; ++i) status.countSample(now);
    measureRate(device, 1.0, settled, now);
  }
};

TEST(DeviceHealth, IsStaleWithoutASampleForNineTenthsOfASecond) {
  Lidar lidar;
  EXPECT_FALSE(ageOf(lidar.device, kNow)) << "none came yet";
  EXPECT_EQ(stateOf(lidar.device, kNow), DeviceState::kStreaming);
  EXPECT_EQ(lidar.reason(), "");
  lidar.status.countSample(kNow);
  EXPECT_EQ(stateOf(lidar.device, kNow + 900ms), DeviceState::kStreaming);
  EXPECT_EQ(stateOf(lidar.device, kNow + 901ms), DeviceState::kStale);
  EXPECT_EQ(lidar.reason(kNow + 900ms), "");
  EXPECT_EQ(lidar.reason(kNow + 1300ms), "no data for 1.3 s, port present");
  EXPECT_EQ(ageOf(lidar.device, kNow + 1300ms), Duration(1300ms));
  for (const DeviceState other : {DeviceState::kAbsent, DeviceState::kOpening, DeviceState::kFault}) {
    lidar.status.set(other, "no such port");
    EXPECT_EQ(stateOf(lidar.device, kNow + 5s), other) << "the driver knows better";
  }
  EXPECT_EQ(lidar.reason(kNow + 5s), "no data for 5.0 s, no such port");
  lidar.status.set(DeviceState::kStale, "no data, is it wedged?");
  EXPECT_EQ(lidar.reason(kNow + 5s), "no data for 5.0 s, is it wedged?");
}

TEST(DeviceHealth, LetsOthersWhoSendOverLcmTakeTwoSeconds) {
  Lidar lidar;
  lidar.device.over_lcm = true;
  lidar.status.countSample(kNow);
  EXPECT_EQ(stateOf(lidar.device, kNow + 2s), DeviceState::kStreaming);
  EXPECT_EQ(stateOf(lidar.device, kNow + 2001ms), DeviceState::kStale);
  EXPECT_EQ(lidar.reason(kNow + 2500ms), "no data for 2.5 s, nobody sends it over LCM");
}

TEST(DeviceHealth, SaysThatSamplesComeTooSeldom) {
  for (const auto& [samples, slow] : {std::pair(10, false), {7, false}, {6, true}, {1, true}}) {
    Lidar lidar;
    lidar.measure(10);
    lidar.measure(samples);
    EXPECT_EQ(lidar.device.rate, samples);
    EXPECT_EQ(lidar.reason(), slow ? std::to_string(samples) + ".0 Hz where 10.0 Hz are expected" : "");
  }
}

TEST(DeviceHealth, JudgesNoRateOfASecondInWhichTheDeviceCameOrWent) {
  Lidar lidar;
  lidar.measure(3);
  EXPECT_FALSE(lidar.device.judged) << "it came";
  lidar.measure(3);
  EXPECT_TRUE(lidar.device.judged);
  lidar.measure(3, kNow, /*settled=*/false);
  EXPECT_FALSE(lidar.device.judged) << "slamd has just begun";
  lidar.measure(3);
  lidar.status.set(DeviceState::kOpening, "looking for it");
  lidar.measure(3);
  EXPECT_FALSE(lidar.device.judged) << "it went";
  EXPECT_EQ(lidar.reason(), "looking for it");
  lidar.status.set(DeviceState::kStreaming, "");
  lidar.measure(3);
  EXPECT_FALSE(lidar.device.judged);
  lidar.measure(3);
  EXPECT_TRUE(lidar.device.judged);
  lidar.measure(0, kNow + 901ms);
  EXPECT_FALSE(lidar.device.judged) << "silent";
}

TEST(DeviceHealth, MeasuresRatesOverTheTimeThatPassed) {
  Lidar lidar;
  for (int i = 0; i < 30; ++i) lidar.status.countSample(kNow);
  measureRate(lidar.device, 2.0, true, kNow);
  EXPECT_EQ(lidar.device.rate, 15.0);
  measureRate(lidar.device, 2.0, true, kNow);
  EXPECT_EQ(lidar.device.rate, 0.0) << "of the samples since then";
}

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

TEST(StageHealth, NamesEachHistogramOfTheExchange) {
  const auto exchange = std::make_unique<Exchange>();
  int count = 0;
  for (LatencyHistogram* histogram : {&exchange->match, &exchange->scan_work, &exchange->scan_to_pose,
                                      &exchange->depth_work, &exchange->map_update, &exchange->optimise}) {
    ++count;
    for (int i = 0; i < count; ++i) histogram->add(1ms);
  }
  std::map<std::string, std::int64_t> counts;
  for (const stage_health_t& stage : stagesOf(*exchange)) counts[stage.name] = stage.count;
  EXPECT_THAT(counts, testing::ElementsAre(testing::Pair("depth", 4), testing::Pair("loop_closure", 6),
                                           testing::Pair("map", 5), testing::Pair("match", 1),
                                           testing::Pair("scan_to_pose", 3), testing::Pair("scan_work", 2)));
}

/// One more element than a queue has room for, and so many more.
template <typename T>
void overfill(SpscQueue<T>& queue, int drops) {
  const auto element = std::make_unique<T>();
  while (queue.tryPush(*element)) continue;
  for (int i = 1; i < drops; ++i) queue.tryPush(*element);
}

TEST(Counters, CarryEachItsOwnValue) {
  const auto exchange = std::make_unique<Exchange>();
  PoseSnapshot snapshot;
  std::map<std::string, std::int64_t> expected;
  std::int64_t next = 100;
  const auto set = [&](const char* name, auto& value) { value = static_cast<std::uint32_t>(expected[name] = ++next); };
  LocalizerCounters& l = snapshot.counters;
  set("scans", l.scans), set("scans.matched", l.matched), set("scans.partly_observable", l.partly_observable);
  set("scans.unmatched", l.unmatched), set("scans.gated", l.gated), set("scans.held", l.scans_held);
  set("scans.retimed", l.scans_retimed), set("scans.too_late", l.scans_too_late);
  set("scans.repeated", l.scans_repeated), set("clock_resets", l.clock_resets), set("samples.far_ahead", l.far_ahead);
  set("wheels.withdrawn", l.wheels_withdrawn), set("keyframes", l.keyframes), set("scans.searched", l.searched);
  set("lost", l.lost), set("samples.late", l.samples_late), set("samples.too_old", l.samples_too_old);
  set("views", l.views), set("views.unplaced", l.views_unplaced);
  l.wheels_scale = 1.0316;
  expected["wheels.scale_permille"] = 1032;
  EkfCounters& f = snapshot.filter;
  set("ekf.wheels_rejected", f.wheels_rejected), set("ekf.gyro_rejected", f.gyro_rejected);
  set("ekf.poses_rejected", f.poses_rejected), set("ekf.standstill_updates", f.standstill_updates);
  set("loop_closures", exchange->loop_closures), set("loop_closures.revoked", exchange->revoked_closures);
  set("relocalised", exchange->relocalised), set("maps.begun_anew", exchange->maps_begun_anew);
  set("lcm.published", exchange->published), set("lcm.failures", exchange->publish_failures);
  set("lcm.bad_messages", exchange->bad_messages), set("lcm.fragments", exchange->lcm_fragments);
  set("lcm.other_packets", exchange->lcm_other_packets), set("lcm.dropped", exchange->lcm_dropped);
  set("socket.clients", exchange->socket_clients), set("socket.bad_packets", exchange->socket_bad);
  set("socket.dropped_clients", exchange->socket_dropped), set("socket.refused_clients", exchange->socket_refused);
  overfill(exchange->scans, 1), overfill(exchange->wheels, 2), overfill(exchange->imu, 3);
  overfill(exchange->views, 4), overfill(exchange->sights, 5), overfill(exchange->keyframes, 6);
  expected["drops.scans"] = 1, expected["drops.wheels"] = 2, expected["drops.imu"] = 3;
  expected["drops.views"] = 4, expected["drops.sights"] = 5, expected["drops.keyframes"] = 6;

  std::map<std::string, std::int64_t> counters;
  for (const counter_t& counter : countersOf(snapshot, *exchange)) counters[counter.name] = counter.value;
  EXPECT_THAT(counters, testing::ContainerEq(expected));
}

}  // namespace
}  // namespace slam
