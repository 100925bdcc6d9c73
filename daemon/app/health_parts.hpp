// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <slam/counter_t.hpp>
#include <slam/stage_health_t.hpp>
#include <string>
#include <vector>

#include "app/exchange.hpp"
#include "core/timestamp.hpp"
#include "drivers/device_status.hpp"
#include "runtime/latency_histogram.hpp"

/// The parts that SLAM_HEALTH is made of.
namespace slam {

/// One device as the supervisor sees it, whatever thread feeds it.
struct WatchedDevice {
  std::string name;
  DeviceStatus* status;
  double expected;  ///< [Hz]
  bool over_lcm = false;
  double lines = 5.0;        ///< of the log that may be written about it now
  Timestamp looked{};        ///< when that was reckoned
  std::string logged = {};   ///< state and reason logged last
  std::int64_t samples = 0;  ///< when rates were measured last
  double rate = 0.0;         ///< [Hz] then
  bool streamed = false;     ///< then
  bool judged = false;       ///< the rate is worth a word
};

/// Of its last sample; std::nullopt: none came yet.
std::optional<Duration> ageOf(const WatchedDevice& device, Timestamp now);
DeviceState stateOf(const WatchedDevice& device, Timestamp now);
/// @param reason what its driver says, or what is known better @return empty: nothing is wrong
std::string reasonOf(const WatchedDevice& device, std::string reason, Timestamp now);
/// @param interval [s] since it was measured last @param settled slamd has run for long enough to judge a rate
void measureRate(WatchedDevice& device, double interval, bool settled, Timestamp now);

counter_t counterOf(const std::string& name, std::uint64_t value);
stage_health_t stageOf(const std::string& name, const LatencyHistogram& histogram);
/// What is counted and measured beside the threads themselves.
std::vector<counter_t> countersOf(const PoseSnapshot& snapshot, const Exchange& exchange);
std::vector<stage_health_t> stagesOf(const Exchange& exchange);

}  // namespace slam
