// SPDX-License-Identifier: BSD-3-Clause
#include <string>
#include <utility>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/messages.hpp"
#include "tools/convert/formats.hpp"
#include "tools/convert/log_output.hpp"

namespace slam {
namespace {

std::pair<std::int64_t, std::int64_t> timeSpan(const std::filesystem::path& log) {
  EventLogReader reader(log);
  std::int64_t first = 0, last = 0;
  for (LogEvent event; reader.next(event); last = event.utime) {
    if (first == 0) first = event.utime;
  }
  return {first, last};
}

/// @return nothing of a message that does not decode, which is counted
template <typename Message>
auto decode(const LogEvent& event, const std::string& file, Recording& report) {
  const auto message = decodeChecked<Message>(event.data);
  auto sample = message ? fromMessage(*message) : std::nullopt;
  if (!sample) report.reject(file, "a " + std::string(event.channel) + " message that does not decode");
  return sample;
}

}  // namespace

Recording disturbLog(const std::filesystem::path& in, const std::filesystem::path& out,
                     const Disturbance& disturbance) {
  const auto [first, last] = timeSpan(in);
  FaultyWheels wheels(disturbance.wheels, disturbance.seed, first, last);
  const std::int64_t middle = first + (last - first) / 2;
  EventLogReader reader(in);
  const std::string file = in.filename().string();
  Recording report;
  LogOutput log;
  for (LogEvent event; reader.next(event);) {
    const std::int64_t set_back = disturbance.time_backwards && event.utime > middle ? 30'000'000 : 0;
    const auto stamp = [set_back](const auto& sample) { return toMicroseconds(sample.stamp) - set_back; };
    if (event.channel == channel::kScan) {
      auto scan = decode<scan_t>(event, file, report);
      if (!scan) continue;
      disturbance.lidar.apply(*scan);
      const bool late = disturbance.time_backwards && report.scans % 10 == 9;
      for (int copy = 0; copy < (disturbance.double_scans ? 2 : 1); ++copy) {
        log.add(event.utime, *scan, stamp(*scan) - (late ? 300'000 : 0));
        ++report.scans;
      }
    } else if (event.channel == channel::kWheels) {
      const auto sample = decode<wheels_t>(event, file, report);
      if (!sample) continue;
      log.add(event.utime, wheels.apply(*sample), stamp(*sample));
      ++report.wheels;
    } else if (event.channel == channel::kImu) {
      const auto sample = decode<imu_t>(event, file, report);
      if (!sample) continue;
      log.add(event.utime, disturbance.imu.apply(*sample), stamp(*sample));
      ++report.imu;
    }
  }
  log.write(out);
  return report;
}

}  // namespace slam
