// SPDX-License-Identifier: BSD-3-Clause
#include "app/health_parts.hpp"

#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kStaleAfter = 900ms;  // without a sample ...
constexpr Duration kLcmStaleAfter = 2s;  // ... that others send, who may be slow

bool isSilent(const WatchedDevice& device, Timestamp now) {
  return ageOf(device, now) > (device.over_lcm ? kLcmStaleAfter : kStaleAfter);
}

}  // namespace

std::optional<Duration> ageOf(const WatchedDevice& device, Timestamp now) {
  const std::int64_t last = device.status->last_sample_ns.load(std::memory_order_relaxed);
  return last == 0 ? std::nullopt : std::optional(now - Timestamp(Duration(last)));
}

DeviceState stateOf(const WatchedDevice& device, Timestamp now) {
  const DeviceState state = device.status->state.load(std::memory_order_acquire);
  return state == DeviceState::kStreaming && isSilent(device, now) ? DeviceState::kStale : state;
}

std::string reasonOf(const WatchedDevice& device, std::string reason, Timestamp now) {
  const bool silent = isSilent(device, now);
  char text[64];
  constexpr double kSlow = 0.7;  // [1] of the expected rate
  if (reason.empty() && !silent && device.judged && device.rate < kSlow * device.expected) {
    std::snprintf(text, sizeof text, "%.1f Hz where %.1f Hz are expected", device.rate, device.expected);
    return text;
  }
  if (!silent) return reason;
  if (reason.empty()) reason = device.over_lcm ? "nobody sends it over LCM" : "port present";
  constexpr std::string_view kNoData = "no data, ";  // as a driver begins that cannot tell since when
  if (reason.starts_with(kNoData)) reason.erase(0, kNoData.size());
  std::snprintf(text, sizeof text, "no data for %.1f s, ", toSeconds(*ageOf(device, now)));
  return text + reason;
}

void measureRate(WatchedDevice& device, double interval, bool settled, Timestamp now) {
  const std::int64_t samples = device.status->samples.load(std::memory_order_relaxed);
  device.rate = static_cast<double>(samples - device.samples) / interval;
  device.samples = samples;
  // A second in which the device came or went says nothing of its rate.
  const bool streams = stateOf(device, now) == DeviceState::kStreaming;
  device.judged = streams && device.streamed && settled;
  device.streamed = streams;
}

counter_t counterOf(const std::string& name, std::uint64_t value) {
  counter_t c{};
  c.name = name;
  c.value = static_cast<std::int64_t>(value);
  return c;
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

std::vector<counter_t> countersOf(const PoseSnapshot& snapshot, const Exchange& exchange) {
  const LocalizerCounters& l = snapshot.counters;
  const EkfCounters& f = snapshot.filter;
  return {counterOf("scans", l.scans),
          counterOf("scans.matched", l.matched),
          counterOf("scans.partly_observable", l.partly_observable),
          counterOf("scans.unmatched", l.unmatched),
          counterOf("scans.gated", l.gated),
          counterOf("scans.held", l.scans_held),
          counterOf("scans.retimed", l.scans_retimed),
          counterOf("scans.too_late", l.scans_too_late),
          counterOf("scans.repeated", l.scans_repeated),
          counterOf("clock_resets", l.clock_resets),
          counterOf("samples.far_ahead", l.far_ahead),
          counterOf("wheels.withdrawn", l.wheels_withdrawn),
          counterOf("wheels.scale_permille", static_cast<std::uint64_t>(std::lround(1000.0 * l.wheels_scale))),
          counterOf("keyframes", l.keyframes),
          counterOf("scans.searched", l.searched),
          counterOf("loop_closures", static_cast<std::uint64_t>(exchange.loop_closures.load())),
          counterOf("lost", l.lost),
          counterOf("relocalised", static_cast<std::uint64_t>(exchange.relocalised.load())),
          counterOf("maps.begun_anew", static_cast<std::uint64_t>(exchange.maps_begun_anew.load())),
          counterOf("loop_closures.revoked", static_cast<std::uint64_t>(exchange.revoked_closures.load())),
          counterOf("samples.late", l.samples_late),
          counterOf("samples.too_old", l.samples_too_old),
          counterOf("ekf.wheels_rejected", f.wheels_rejected),
          counterOf("ekf.gyro_rejected", f.gyro_rejected),
          counterOf("ekf.poses_rejected", f.poses_rejected),
          counterOf("ekf.standstill_updates", f.standstill_updates),
          counterOf("drops.scans", exchange.scans.drops()),
          counterOf("drops.wheels", exchange.wheels.drops()),
          counterOf("drops.imu", exchange.imu.drops()),
          counterOf("views", l.views),
          counterOf("views.unplaced", l.views_unplaced),
          counterOf("drops.views", exchange.views.drops()),
          counterOf("drops.sights", exchange.sights.drops()),
          counterOf("drops.keyframes", exchange.keyframes.drops()),
          counterOf("lcm.published", static_cast<std::uint64_t>(exchange.published.load())),
          counterOf("lcm.failures", static_cast<std::uint64_t>(exchange.publish_failures.load())),
          counterOf("lcm.bad_messages", static_cast<std::uint64_t>(exchange.bad_messages.load())),
          counterOf("lcm.fragments", exchange.lcm_fragments),
          counterOf("lcm.other_packets", exchange.lcm_other_packets),
          counterOf("lcm.dropped", exchange.lcm_dropped),
          counterOf("socket.clients", exchange.socket_clients),
          counterOf("socket.bad_packets", exchange.socket_bad),
          counterOf("socket.dropped_clients", exchange.socket_dropped),
          counterOf("socket.refused_clients", exchange.socket_refused)};
}

std::vector<stage_health_t> stagesOf(const Exchange& exchange) {
  return {stageOf("match", exchange.match),
          stageOf("scan_work", exchange.scan_work),
          stageOf("scan_to_pose", exchange.scan_to_pose),
          stageOf("depth", exchange.depth_work),
          stageOf("map", exchange.map_update),
          stageOf("loop_closure", exchange.optimise)};
}

}  // namespace slam
