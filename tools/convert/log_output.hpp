// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bus/event_log.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {

/// What a conversion did, for the line that the program prints.
struct ConvertReport {
  int scans = 0, wheels = 0, imu = 0;
  int poses = 0;                ///< of a reference trajectory, written apart
  int rejected = 0;             ///< records that were not understood
  std::string first_rejection;  ///< where and why, of the first
  void reject(const std::string& where, const std::string& why) {
    if (rejected++ == 0) first_rejection = where + ": " + why;
  }
};

/// Says so when a compressed input was cut off or damaged: what came before it was used.
inline void reportDamage(const TextFile& file, const std::filesystem::path& name, ConvertReport& report) {
  if (file.damaged()) {
    report.reject(name.filename().string() + ":" + std::to_string(file.lineNumber()),
                  "the compressed data is damaged here");
  }
}

/// Collects samples of several sensors and writes them as one log in the order of arrival times. The stamp inside a
/// message stays as recorded, also where it goes back; only the log's own event times never go back.
class LogOutput {
 public:
  void add(std::int64_t arrival, const LaserScan& scan, std::int64_t utime);
  void add(std::int64_t arrival, const WheelSample& sample, std::int64_t utime, std::vector<double> angles = {});
  void add(std::int64_t arrival, const ImuSample& sample, std::int64_t utime);

  /// @throws std::runtime_error when the file cannot be written or there is nothing to write
  void write(const std::filesystem::path& file);

 private:
  struct Record {
    std::int64_t arrival;
    const char* channel;
    std::vector<std::uint8_t> data;
  };
  template <typename Message>
  void append(std::int64_t arrival, const char* channel, const Message& message);
  std::vector<Record> records_;
};

}  // namespace slam
