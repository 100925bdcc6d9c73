// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "bus/event_log.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "tools/convert/recording.hpp"
#include "tools/convert/sqlite.hpp"

namespace slam {

/// Collects samples of several sensors and writes them as one log in the order of arrival times. The stamp inside a
/// message stays as recorded, also where it goes back; only the log's own event times never go back. Needs little
/// memory, however much it collects: the messages wait in a temporary database, which sorts them.
class LogOutput {
 public:
  /// @param memory [bytes] of the messages that wait in memory, about
  /// @throws std::runtime_error when a temporary file cannot be made
  explicit LogOutput(std::size_t memory = std::size_t{8} << 20);

  void add(std::int64_t arrival, const LaserScan& scan, std::int64_t utime);
  void add(std::int64_t arrival, const WheelSample& sample, std::int64_t utime, std::span<const double> angles = {});
  void add(std::int64_t arrival, const ImuSample& sample, std::int64_t utime);
  /// A message as it was recorded. @throws std::runtime_error when the temporary file cannot be written
  /// @param channel one of those in channels.hpp
  void add(std::int64_t arrival, const char* channel, std::span<const std::uint8_t> message);

  /// @param recording gets a rejection for each sample that was left out, because it cannot be
  /// @throws std::runtime_error when the file cannot be written or there is nothing to write
  void write(const std::filesystem::path& file, Recording* recording = nullptr);

 private:
  template <typename Message>
  void append(std::int64_t arrival, const char* channel, const Message& message);
  void check(bool good) const;

  Database waiting_;
  Statement insert_;
  std::vector<std::uint8_t> message_;
  int implausible_wheels_ = 0, implausible_imu_ = 0;  // samples that were left out
  bool empty_ = true;
};

}  // namespace slam
