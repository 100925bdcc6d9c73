// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/scan.hpp"
#include "drivers/lidar/lidar_decoder.hpp"
#include "drivers/lidar/scan_assembler.hpp"
#include "drivers/lidar/text_watch.hpp"
#include "timing/sample_clock.hpp"

namespace slam {

/// From the bytes of a running scan, with their arrival, to LaserScans whose beams carry the time of their sampling.
/// Pure: time comes with the bytes. Does not allocate after construction.
class LidarScanStream {
 public:
  struct Format {
    double sample_time = 508e-6;         ///< [s] per sample
    double byte_time = 10.0 / 115200.0;  ///< [s] on the line
    ScanAssembler::Limits limits{};      ///< written into the scans
    std::string_view boot_text{};        ///< that the unit sends after its reset; empty: none
  };
  using Sink = std::function<void(const LaserScan&)>;

  LidarScanStream(std::unique_ptr<LidarDecoder> decoder, const Format& format);

  /// @param arrival of the last of `bytes`. @return nodes decoded
  int push(std::span<const std::uint8_t> bytes, Timestamp arrival, const Sink& sink);
  /// Begins anew behind a gap: the turn under way has a hole, and its stamps are doubtful.
  void restart();
  /// Takes nothing from bytes that are too old but whether the unit restarted.
  void skip(std::span<const std::uint8_t> bytes);
  bool sawBootText() const { return saw_boot_text_; }
  std::int64_t rejects() const;                                  ///< nodes and packets refused, turns given up
  std::uint32_t turns() const { return assembler_.turns(); }     ///< that the head has made, given up or not
  std::int64_t thinned() const { return assembler_.thinned(); }  ///< measurements left out evenly
  int stride() const { return assembler_.stride(); }             ///< of the last finished turn

 protected:
  const LidarDecoder& decoder() const { return *decoder_; }

 private:
  Format format_;
  std::unique_ptr<LidarDecoder> decoder_;
  SampleClock clock_;
  ScanAssembler assembler_;
  std::vector<TimedNode> nodes_;
  TextWatch boot_text_;
  bool saw_boot_text_ = false;
  std::uint32_t zero_shifts_ = 0, restarts_ = 0;
};

}  // namespace slam
