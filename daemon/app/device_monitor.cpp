// SPDX-License-Identifier: BSD-3-Clause
#include "app/device_monitor.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "app/log/log.hpp"
#include "diagnostics/sensor_problems.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kStaleAfter = 900ms;  // without a sample ...
constexpr Duration kLcmStaleAfter = 2s;  // ... that others send, who may be slow
constexpr Duration kOpened = 3s;         // no device that works takes longer to open
/// Of health that one device may send at once [1], [1/s]: a plug that is pulled and put back has four news, and so has
/// the next one.
constexpr double kMostMessages = 10.0, kMessages = 0.5;

constexpr ProblemKind kIdentity{"identity", "{0}"};  // none: it tells one line about a device from another

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

Problem problemOf(const WatchedDevice& device, const Problem& found, Timestamp now) {
  constexpr double kSlow = 0.7;     // [1] of the expected rate
  constexpr double kDamaged = 0.1;  // [1] of it, refused: a good line loses nothing
  if (device.starved && found.is(problem::kBoardLate)) return problem::kStarved;
  if (found) return found;
  if (isSilent(device, now)) {
    if (device.starved) return problem::kStarved;
    return device.over_lcm ? problem::kLcmSilent : problem::kSilent;
  }
  if (!device.rate_valid || device.rate >= kSlow * device.expected) return {};
  const bool damaged = device.refused >= kDamaged * device.expected;
  return {damaged ? problem::kDamaged : problem::kSlow, {device.rate, device.expected, device.refused}};
}

std::string silenceOf(const WatchedDevice& device, Timestamp now) {
  if (!isSilent(device, now)) return "";
  char text[32];
  std::snprintf(text, sizeof text, "no data for %.1f s, ", toSeconds(*ageOf(device, now)));
  return text;
}

void measureRate(WatchedDevice& device, double interval, bool settled, Timestamp now) {
  const std::int64_t samples = device.status->samples.load(std::memory_order_relaxed);
  device.rate = static_cast<double>(samples - device.samples) / interval;
  device.samples = samples;
  const std::int64_t rejects = device.status->rejects.load(std::memory_order_relaxed);
  device.refused = static_cast<double>(rejects - device.rejects) / interval;
  device.rejects = rejects;
  // A second in which the device came or went does not show its rate.
  const bool streams = stateOf(device, now) == DeviceState::kStreaming;
  device.rate_valid = streams && device.streamed && settled && !device.starved;
  device.streamed = streams;
}

void DeviceMonitor::begin() {
  for (WatchedDevice& device : devices_) {
    device.samples = device.status->samples;
    device.rejects = device.status->rejects;
  }
}

void DeviceMonitor::measureRates(double interval, bool settled, Timestamp now) {
  for (WatchedDevice& device : devices_) measureRate(device, interval, settled, now);
}

Problem DeviceMonitor::found(const WatchedDevice& device) const {
  if (device.name == "lidar" && lidar_stuck_) return problem::kLidarStuck;
  const Problem problem = device.status->problem();
  const bool blind = device.name == "lidar" && !problem && echoes_ != EchoWatch::Finding::kNone;
  return blind ? problemOf(echoes_) : problem;
}

bool DeviceMonitor::look(Timestamp now) {
  bool news = false;
  for (WatchedDevice& device : devices_) {
    const DeviceState state = stateOf(device, now);
    if (state != DeviceState::kOpening) device.opening_since.reset();
    if (state == DeviceState::kOpening && !device.opening_since) device.opening_since = now;
    // One that alternates for long has news every two seconds.
    device.messages = std::min(kMostMessages, device.messages + kMessages * toSeconds(now - device.looked));
    device.looked = now;
    const Problem problem = found(device);
    const bool same = !device.is_new && state == device.seen_state && problem.isSame(device.seen);
    if (same || device.messages < 1.0) continue;
    device.messages -= 1.0;
    device.seen_state = state;
    device.seen = problem;
    device.is_new = false;
    news = true;
  }
  return news;
}

std::vector<Trouble> DeviceMonitor::problems(Timestamp now) const {
  std::vector<Trouble> problems;
  for (const WatchedDevice& device : devices_) {
    const bool goes_on = !device.without.empty() && (device.by.empty() || streams(device.by, now));
    if (const Problem problem = problemOf(device, found(device), now))
      problems.push_back({.device = device.name,
                          .problem = problem,
                          .begin = device.name + ": ",
                          .since = silenceOf(device, now),
                          .meanwhile = goes_on ? "slamd " + device.without : "",
                          .recovery = device.name + " STREAMING",
                          .fault = stateOf(device, now) != DeviceState::kStreaming});
  }
  return problems;
}

std::vector<Trouble> DeviceMonitor::troubles(Timestamp now) {
  std::vector<Trouble> troubles = problems(now);
  for (Trouble& trouble : troubles) {
    const WatchedDevice& device = *std::find_if(devices_.begin(), devices_.end(),
                                                [&](const WatchedDevice& d) { return d.name == trouble.device; });
    const DeviceState state = stateOf(device, now);
    trouble.begin = device.name + " " + nameOf(state) + ": ";
    const bool opens = device.opening_since && now - *device.opening_since < kOpened;
    if (state == DeviceState::kOpening && opens) trouble.problem = {};  // not over, and no news
  }
  return troubles;
}

std::vector<LogLine> DeviceMonitor::arrivals(TroubleLog& log, Timestamp now) {
  std::vector<LogLine> lines;
  for (WatchedDevice& device : devices_) {
    const std::int64_t identified = device.status->identified.load(std::memory_order_acquire);
    if (std::exchange(device.identified, identified) != identified) {
      const std::string text = device.name + ": " + device.status->identity.load(std::memory_order_acquire);
      if (auto line = log.happened(device.name, {kIdentity, {}, {text}}, text, LogLine::kInfo, now))
        lines.push_back(std::move(*line));
    }
    const bool first = stateOf(device, now) == DeviceState::kStreaming && !std::exchange(device.has_streamed, true);
    // One that was missed is reported as it recovers.
    if (first && !log.isOpen(device.name)) lines.push_back({LogLine::kInfo, device.name + " STREAMING"});
  }
  return lines;
}

std::vector<device_health_t> DeviceMonitor::health(Timestamp now) const {
  std::vector<device_health_t> all;
  for (const WatchedDevice& device : devices_) {
    device_health_t d{};
    d.name = device.name;
    d.state = static_cast<std::uint8_t>(stateOf(device, now));
    if (const Problem problem = problemOf(device, found(device), now))
      d.reason = silenceOf(device, now) + problem.words();
    const std::optional<Duration> age = ageOf(device, now);
    d.age = age ? toSeconds(*age) : -1.0;
    d.samples = device.status->samples.load(std::memory_order_relaxed);
    d.rate = device.rate;
    d.expected = device.expected;
    d.rejects = device.status->rejects.load(std::memory_order_relaxed);
    all.push_back(std::move(d));
  }
  return all;
}

bool DeviceMonitor::streams(const std::string& name, Timestamp now) const {
  return std::any_of(devices_.begin(), devices_.end(), [&](const WatchedDevice& device) {
    return device.name == name && stateOf(device, now) == DeviceState::kStreaming;
  });
}

std::string DeviceMonitor::identities() const {
  std::string text;
  for (const WatchedDevice& device : devices_) {
    const std::string identity = device.status->identity.load(std::memory_order_acquire);
    if (!identity.empty()) text += "; " + device.name + " is " + identity;
  }
  return text;
}

}  // namespace slam
