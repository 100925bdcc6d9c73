// SPDX-License-Identifier: BSD-3-Clause
#include "app/device_monitor.hpp"

#include <algorithm>
#include <cstdio>
#include <span>
#include <string_view>
#include <utility>

#include "app/log/log.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kStaleAfter = 900ms;  // without a sample ...
constexpr Duration kLcmStaleAfter = 2s;  // ... that others send, who may be slow
constexpr Duration kOpened = 3s;         // no device that works takes longer to open
/// Of health that one device may send at once [1], [1/s]: a plug that is pulled and put back has four news, and so has
/// the next one.
constexpr double kMostMessages = 10.0, kMessages = 0.5;

bool isSilent(const WatchedDevice& device, Timestamp now) {
  return ageOf(device, now) > (device.over_lcm ? kLcmStaleAfter : kStaleAfter);
}

/// Drivers know causes and fixes. What follows from them depends on the other devices.
std::string withConsequence(const WatchedDevice& device, std::string reason) {
  const bool known = *device.without == '\0' || reason.find("slamd ") != std::string::npos;
  return known ? std::move(reason) : std::move(reason) + "; slamd " + device.without;
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
  char text[320];
  constexpr double kSlow = 0.7;     // [1] of the expected rate
  constexpr double kDamaged = 0.1;  // [1] of it, refused: a good line loses nothing
  if (reason.empty() && !silent && device.judged && device.rate < kSlow * device.expected) {
    const bool damaged = device.refused >= kDamaged * device.expected;
    const int size =
        std::snprintf(text, sizeof text, "%.1f Hz where %.1f Hz are expected", device.rate, device.expected);
    const std::span rest(text + size, text + sizeof text);
    damaged
        ? std::snprintf(rest.data(), rest.size(),
                        ", for %.1f a second are lost or damaged on the line: slamd goes on with those that are "
                        "whole; check the cable, its plugs and its ground, or take another USB socket without a hub",
                        device.refused)
        : std::snprintf(rest.data(), rest.size(),
                        ", and nothing is damaged on the line: slamd goes on with what comes; check at which rate "
                        "the device is set to send, and its power");
    return text;
  }
  if (!silent) return reason;
  if (reason.empty() && device.starved) reason = "the computer is overloaded";
  if (reason.empty()) reason = device.over_lcm ? "nobody sends it over LCM" : "port present, but silent: pull its plug";
  constexpr std::string_view kNoData = "no data, ";  // as a driver begins that cannot tell since when
  if (reason.starts_with(kNoData)) reason.erase(0, kNoData.size());
  std::snprintf(text, sizeof text, "no data for %.1f s, ", toSeconds(*ageOf(device, now)));
  return text + reason;
}

void measureRate(WatchedDevice& device, double interval, bool settled, Timestamp now) {
  const std::int64_t samples = device.status->samples.load(std::memory_order_relaxed);
  device.rate = static_cast<double>(samples - device.samples) / interval;
  device.samples = samples;
  const std::int64_t rejects = device.status->rejects.load(std::memory_order_relaxed);
  device.refused = static_cast<double>(rejects - device.rejects) / interval;
  device.rejects = rejects;
  // A second in which the device came or went says nothing of its rate.
  const bool streams = stateOf(device, now) == DeviceState::kStreaming;
  device.judged = streams && device.streamed && settled && !device.starved;
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

std::string DeviceMonitor::statusReason(const WatchedDevice& device) const {
  if (device.name == "lidar" && lidar_stuck_) {
    return "every turn shows the same ranges although the robot moves: the lidar is stuck, pull its plug";
  }
  const std::string reason = device.status->reason.load(std::memory_order_acquire);
  const bool blind = device.name == "lidar" && reason.empty() && echoes_ != EchoWatch::Finding::kNone;
  return blind ? describe(echoes_) : reason;
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
    std::string seen = std::string(nameOf(state)) + statusReason(device);
    if (seen == device.seen || device.messages < 1.0) continue;
    device.messages -= 1.0;
    device.seen = std::move(seen);
    news = true;
  }
  return news;
}

std::vector<Trouble> DeviceMonitor::troubles(Timestamp now) {
  std::vector<Trouble> troubles;
  for (WatchedDevice& device : devices_) {
    const DeviceState state = stateOf(device, now);
    std::string status = statusReason(device), reason = reasonOf(device, status, now);
    if (state == DeviceState::kStreaming && reason.empty()) continue;
    Trouble& trouble = troubles.emplace_back();
    trouble.cause = device.name;
    const bool opens = device.opening_since && now - *device.opening_since < kOpened;
    if (state == DeviceState::kOpening && opens) continue;  // not over, and no news
    trouble.recovery = device.name + " STREAMING";
    trouble.reason = status.empty() ? nameOf(state) : std::move(status);
    trouble.text = device.name + " " + nameOf(state) + ": " + withConsequence(device, std::move(reason));
  }
  return troubles;
}

std::vector<LogLine> DeviceMonitor::arrivals(TroubleLog& log, Timestamp now) {
  std::vector<LogLine> lines;
  for (WatchedDevice& device : devices_) {
    const std::int64_t identified = device.status->identified.load(std::memory_order_acquire);
    if (std::exchange(device.identified, identified) != identified) {
      const std::string text = device.name + ": " + device.status->identity.load(std::memory_order_acquire);
      if (auto line = log.happened(device.name, text, LogLine::kInfo, now)) lines.push_back(std::move(*line));
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
    d.reason = reasonOf(device, statusReason(device), now);
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

std::string DeviceMonitor::problems(Timestamp now) const {
  std::string text;
  for (const WatchedDevice& device : devices_) {
    const std::string reason = reasonOf(device, statusReason(device), now);
    if (!reason.empty()) text += "; " + device.name + ": " + withConsequence(device, reason);
  }
  return text;
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
