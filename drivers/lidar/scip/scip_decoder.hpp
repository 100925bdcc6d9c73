// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/lidar/codec/scip_codec.hpp"
#include "drivers/lidar/lidar_decoder.hpp"

namespace slam {

/// Scans of a running MD command: each is its echo, status, time stamp and lines of ranges, up to an empty line. One
/// with a wrong sum, or too few or too many ranges, is left out whole. How many are missing is known by the stamps.
class ScipDecoder final : public LidarDecoder {
 public:
  /// @param command that began the scan. @param byte_time [s] on the line
  ScipDecoder(const scip::Parameters& unit, std::string command, double byte_time);

  void push(std::uint8_t byte, std::vector<TimedNode>& nodes) override;
  void reset() override;
  std::size_t mostNodes() const override { return static_cast<std::size_t>(unit_.steps()); }

 private:
  static constexpr std::size_t kLongestLine = scip::kLineData + 1;  // [characters]
  enum class Expects : std::uint8_t { kEcho, kStatus, kStamp, kData, kNextScan };

  bool isEcho() const;
  void beginScan();
  void reject();
  void takeLine(std::vector<TimedNode>& nodes);
  void takeScan(std::vector<TimedNode>& nodes);

  scip::Parameters unit_;
  std::string command_;
  double byte_time_;
  Expects expects_ = Expects::kNextScan;
  std::string line_, data_;
  std::size_t bytes_ = 0;  // of the scan
  std::uint32_t stamp_ = 0;
  std::optional<std::uint32_t> last_stamp_;  // [ms] of the last scan given
};

}  // namespace slam
