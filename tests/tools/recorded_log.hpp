// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <gtest/gtest.h>
#include <vector>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "config/loader.hpp"
#include "tools/convert/recording.hpp"

namespace slam::test {

/// What is in a log of ours.
struct Log {
  std::vector<std::int64_t> event_times;
  std::vector<std::int64_t> scan_utimes;
  std::vector<LaserScan> scans;
  std::vector<WheelSample> wheels;
  std::vector<std::vector<double>> angles;  ///< [rad] of each wheel sample
  std::vector<ImuSample> imu_samples;
  std::vector<std::int64_t> scan_events;  ///< [us] when each scan was logged
  int imu = 0;
};

inline Log readLog(const std::filesystem::path& path) {
  Log log;
  EventLogReader reader(path);
  for (LogEvent event; reader.next(event);) {
    log.event_times.push_back(event.utime);
    if (event.channel == channel::kScan) {
      const auto message = decodeChecked<scan_t>(event.data);
      const auto scan = message ? fromMessage(*message) : std::nullopt;
      EXPECT_TRUE(scan);
      if (!scan) continue;
      log.scan_utimes.push_back(message->utime);
      log.scan_events.push_back(event.utime);
      log.scans.push_back(*scan);
    } else if (event.channel == channel::kWheels) {
      const auto message = decodeChecked<wheels_t>(event.data);
      const auto sample = message ? fromMessage(*message) : std::nullopt;
      EXPECT_TRUE(sample);
      if (!sample) continue;
      log.wheels.push_back(*sample);
      log.angles.push_back(message->angles);
    } else if (event.channel == channel::kImu) {
      ++log.imu;
      const auto message = decodeChecked<imu_t>(event.data);
      const auto sample = message ? fromMessage(*message) : std::nullopt;
      EXPECT_TRUE(sample);
      if (sample) log.imu_samples.push_back(*sample);
    }
  }
  return log;
}

/// The configuration of a recording, as slam-replay reads it.
inline Config configOf(const Recording& recording) {
  return parseConfig(configText(recording, "written by a test"), "config");
}

}  // namespace slam::test
