// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bus/event_log.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "tools/convert/recording.hpp"

namespace slam {

/// Collects samples of several sensors and writes them as one log in the order of arrival times. The stamp inside a
/// message stays as recorded, also where it goes back; only the log's own event times never go back. Needs little
/// memory, however much it collects: sorted parts wait in a temporary file and are merged.
class LogOutput {
 public:
  /// @param memory [bytes] of the messages that wait in memory, at most
  explicit LogOutput(std::size_t memory = std::size_t{8} << 20) : memory_(memory) {}

  void add(std::int64_t arrival, const LaserScan& scan, std::int64_t utime);
  void add(std::int64_t arrival, const WheelSample& sample, std::int64_t utime, std::span<const double> angles = {});
  void add(std::int64_t arrival, const ImuSample& sample, std::int64_t utime);
  /// A message as it was recorded. @param channel one of those in channels.hpp
  void add(std::int64_t arrival, const char* channel, std::span<const std::uint8_t> message);

  /// @param recording gets a rejection for each sample that was left out, because it cannot be
  /// @throws std::runtime_error when the file cannot be written or there is nothing to write
  void write(const std::filesystem::path& file, Recording* recording = nullptr);

 private:
  int implausible_wheels_ = 0, implausible_imu_ = 0;  // samples that were left out
  struct Record {
    std::int64_t arrival;
    const char* channel;
    std::uint32_t begin, size;  // in data_
  };
  /// A sorted part in the temporary file.
  struct Part {
    std::uint64_t begin, end;
  };
  class PartReader;
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  template <typename Message>
  void append(std::int64_t arrival, const char* channel, const Message& message);
  void sort();
  void spill();

  std::size_t memory_;
  std::vector<Record> records_;
  std::vector<std::uint8_t> data_, message_;
  std::unique_ptr<std::FILE, Close> spilled_;
  std::vector<Part> parts_;
};

}  // namespace slam
