// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <filesystem>
#include <string>
#include <unistd.h>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "config/loader.hpp"
#include "fuzz/fuzzing.hpp"
#include "tools/convert/recording.hpp"

namespace slam::fuzz {

/// Holds for whatever was converted: all that was written can be read, is what a sensor may say, and is as much as the
/// recording says; the configuration is one that slamd takes.
inline void checkConverted(const Recording& recording, const std::filesystem::path& file) {
  int scans = 0, wheels = 0, imu = 0;
  EventLogReader reader(file);
  for (LogEvent event; reader.next(event);) {
    if (event.channel == channel::kScan) {
      const auto message = decodeChecked<scan_t>(event.data);
      FUZZ_CHECK(message && fromMessage(*message));
      for (const float bearing : message->bearings) FUZZ_CHECK(std::abs(bearing) < 4.0F);
      for (const float range : message->ranges) FUZZ_CHECK(range >= 0.0F);
      ++scans;
    } else if (event.channel == channel::kWheels) {
      const auto message = decodeChecked<wheels_t>(event.data);
      FUZZ_CHECK(message && fromMessage(*message));
      ++wheels;
    } else {
      const auto message = decodeChecked<imu_t>(event.data);
      FUZZ_CHECK(message && fromMessage(*message));
      ++imu;
    }
  }
  FUZZ_CHECK(reader.skippedBytes() == 0 && !reader.truncated());
  FUZZ_CHECK(scans == recording.scans && wheels == recording.wheels && imu == recording.imu);
  FUZZ_CHECK((recording.rejected > 0) != recording.first_rejection.empty());
  if (!recording.configuration) {
    FUZZ_CHECK_NO_THROW(parseConfig(configText(recording, "fuzz"), "fuzz").depth_device.driver == DepthDriver::kNone);
  }
}

/// A file of this process alone, for parsers that ask for a name on a disk.
inline std::filesystem::path scratchFile(const char* name) {
  return std::filesystem::temp_directory_path() / ("slam_fuzz_" + std::to_string(::getpid()) + name);
}

}  // namespace slam::fuzz
