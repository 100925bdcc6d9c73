// SPDX-License-Identifier: BSD-3-Clause
#include "app/counters.hpp"

#include <memory>
#include <type_traits>

namespace slam {
namespace {

/// @param with_statistic the column of its key in statistics
template <typename Value>
std::string rowOf(const CounterInfo& what, const Value&, bool with_statistic) {
  std::string row = "| `" + what.name;
  row += std::is_floating_point_v<Value> ? "_permille` | " : "` | ";  // as of the message
  if (with_statistic) row.append("`").append(what.statistic()).append("` | ");
  return row + what.unit + " | " + what.meaning + " |\n";
}

}  // namespace

std::string printCounters() {
  const FrontEndCounters front_end;
  const EkfCounters filter;
  const BackEndCounters back_end;
  const auto channels = std::make_unique<Channels>();
  const CanLinkCounters can;
  const RecorderCounters recorder;
  const Worker thread({.name = "THREAD", .rate = 1.0}, [] {});
  DeviceStatus device;
  device.thinned = 1;
  const Counted all{.front_end = &front_end,
                    .filter = &filter,
                    .back_end = &back_end,
                    .channels = channels.get(),
                    .threads = {&thread},
                    .devices = {{"DEVICE", &device}},
                    .can = &can,
                    .recorders = {{"record", &recorder}, {"log", &recorder}},
                    .battery = 0.0F,
                    .limited_speeds = 0,
                    .logs = kLogStopped,
                    .echoes = 0.0};
  std::string text =
      "# Counters\n\n"
      "`SLAM_HEALTH` carries these counters once a second. They count from the start of slamd, those of a graph from "
      "the "
      "start\nof its map.\n"
      "This page is written by `slamd --print-counters`.\n\n"
      "## The pipeline\n\n"
      "`slam-replay --stats` writes them, too. There a share is a number; in `SLAM_HEALTH` it is in permille.\n\n"
      "| in `SLAM_HEALTH` | in statistics | unit | meaning |\n|---|---|---|---|\n";
  visitPipelineCounters(all, [&](const CounterInfo& what, const auto& value) { text += rowOf(what, value, true); });
  text +=
      "\n## The daemon\n\n"
      "THREAD is one of base, lidar, depth, estimator, graph, mapper, bus; DEVICE one of lidar, base, imu, depth.\n\n"
      "| in `SLAM_HEALTH` | unit | meaning |\n|---|---|---|\n";
  visitDaemonCounters(all, [&](const CounterInfo& what, const auto& value) { text += rowOf(what, value, false); });
  return text;
}

}  // namespace slam
