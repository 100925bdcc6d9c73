// SPDX-License-Identifier: BSD-3-Clause
#include "tools/faults/stream_fault.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>

namespace slam {
namespace {

constexpr double kStuck = 5.0;  // [s]

void setFarAhead(std::vector<LogSample>& samples) {
  const auto wheels = std::find_if(samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 3), samples.end(),
                                   [](const LogSample& s) { return std::holds_alternative<WheelSample>(s); });
  if (wheels != samples.end()) stampIn(*wheels) += std::chrono::seconds(100);
}

template <typename Kind>
void setAhead(std::vector<LogSample>& samples, int every) {
  int count = 0;
  for (LogSample& sample : samples) {
    if (std::holds_alternative<Kind>(sample) && ++count % every == 0) stampIn(sample) += std::chrono::seconds(1);
  }
}

void setBack(std::vector<LogSample>& samples, bool imu_alone) {
  for (std::size_t i = samples.size() / 2; i < samples.size(); ++i) {
    if (!imu_alone || std::holds_alternative<ImuSample>(samples[i])) stampIn(samples[i]) -= std::chrono::seconds(30);
  }
}

void disorder(std::vector<LogSample>& samples) {
  int scans = 0;
  Timestamp last;
  for (LogSample& sample : samples) {
    if (!isScan(sample)) continue;
    const Timestamp recorded = stampOf(sample);
    if (++scans % 10 == 0) stampIn(sample) -= std::chrono::milliseconds(300);
    if (scans % 10 == 5) stampIn(sample) = last + std::chrono::microseconds(10);
    last = recorded;
  }
}

void copyScans(std::vector<LogSample>& samples) {
  std::vector<LogSample> with_copies;
  for (LogSample& sample : samples) {
    std::unique_ptr<LaserScan> copy;
    if (isScan(sample)) copy = std::make_unique<LaserScan>(*std::get<std::unique_ptr<LaserScan>>(sample));
    with_copies.push_back(std::move(sample));
    if (!copy) continue;
    copy->stamp += std::chrono::milliseconds(10);
    with_copies.emplace_back(std::move(copy));
  }
  samples = std::move(with_copies);
}

void stickLidar(std::vector<LogSample>& samples) {
  const Timestamp begin = stampOf(samples.front()), end = stampOf(samples.back());
  const LaserScan* seen = nullptr;
  for (LogSample& sample : samples) {
    if (!isScan(sample)) continue;
    LaserScan& scan = *std::get<std::unique_ptr<LaserScan>>(sample);
    const double since_first = toSeconds(scan.stamp - begin - (end - begin) / 3);
    const double since_second = since_first - toSeconds((end - begin) / 3);
    const bool stuck = (since_first > 0.0 && since_first < kStuck) || (since_second > 0.0 && since_second < kStuck);
    if (!stuck) seen = &scan;
    if (!stuck || seen == nullptr) continue;
    const Timestamp stamp = scan.stamp;
    scan = *seen;
    scan.stamp = stamp;
  }
}

void delayScans(std::vector<LogSample>& samples) {
  const Timestamp middle = stampOf(samples.front()) + (stampOf(samples.back()) - stampOf(samples.front())) / 2;
  const auto arrival = [&](const LogSample& sample) {
    const Timestamp stamp = stampOf(sample);
    const bool late = isScan(sample) && stamp > middle && stamp < middle + std::chrono::seconds(10);
    return late ? stamp + std::chrono::milliseconds(1500) : stamp;
  };
  std::stable_sort(samples.begin(), samples.end(),
                   [&](const LogSample& a, const LogSample& b) { return arrival(a) < arrival(b); });
}

void delayWheels(std::vector<LogSample>& samples) {
  int count = 0;
  WheelSample* last = nullptr;
  for (LogSample& sample : samples) {
    auto* wheels = std::get_if<WheelSample>(&sample);
    if (wheels == nullptr) continue;
    if (last != nullptr && ++count % 4 == 0) last->stamp += (wheels->stamp - last->stamp) * 9 / 10;
    last = wheels;
  }
}

using Samples = std::vector<LogSample>;
constexpr std::array kFaults = std::to_array<StreamFault>({
    {"-", [](Samples&) {}},
    {"far-ahead", setFarAhead},  // the stamp of one wheel sample lies 100 s ahead
    {"scans-ahead", [](Samples& samples) { setAhead<std::unique_ptr<LaserScan>>(samples, 20); }},  // one in 20, by 1 s
    {"wheels-ahead", [](Samples& samples) { setAhead<WheelSample>(samples, 100); }},               // one in 100, by 1 s
    {"set-back", [](Samples& samples) { setBack(samples, false); }},     // all clocks, by 30 s in the middle
    {"imu-set-back", [](Samples& samples) { setBack(samples, true); }},  // that of the IMU alone
    {"out-of-order", disorder},     // every tenth scan is stamped 0.3 s early, every tenth one almost as the one before
    {"copies", copyScans},          // every scan is sent twice, the second time 10 ms later
    {"stuck", stickLidar},          // the lidar repeats a turn for 5 s, twice
    {"late", delayScans},           // for 10 s scans come 1.5 s late
    {"wheel-jitter", delayWheels},  // every fourth wheel sample is stamped late by almost an interval
});

}  // namespace

Timestamp& stampIn(LogSample& sample) {
  if (auto* scan = std::get_if<std::unique_ptr<LaserScan>>(&sample)) return (*scan)->stamp;
  if (auto* wheels = std::get_if<WheelSample>(&sample)) return wheels->stamp;
  return std::get<ImuSample>(sample).stamp;
}

Timestamp stampOf(const LogSample& sample) {
  if (const auto* scan = std::get_if<std::unique_ptr<LaserScan>>(&sample)) return (*scan)->stamp;
  if (const auto* wheels = std::get_if<WheelSample>(&sample)) return wheels->stamp;
  return std::get<ImuSample>(sample).stamp;
}

const StreamFault& streamFault(std::string_view name) {
  std::string known;
  for (const StreamFault& one : kFaults) {
    if (one.name == name) return one;
    known += (known.empty() ? "" : ", ") + std::string(one.name);
  }
  throw std::invalid_argument("fault " + std::string(name) + " is not known; known are " + known);
}

}  // namespace slam
