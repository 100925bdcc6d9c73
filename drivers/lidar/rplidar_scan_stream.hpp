// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <string_view>

#include "drivers/lidar/lidar_scan_stream.hpp"
#include "drivers/lidar/rplidar_stream.hpp"

namespace slam::rplidar {

inline constexpr std::string_view kBootText = "RP LIDAR";   ///< begins the banner that a unit sends after its reset
inline constexpr std::string_view kBootEndText = "Model:";  ///< in its last line

/// The scan stream of an RPLidar.
class ScanStream : public LidarScanStream {
 public:
  struct Format {
    AnswerType type = AnswerType::kStandardNodes;
    double sample_time = 508e-6;         ///< [s] per sample
    double byte_time = 10.0 / 115200.0;  ///< [s] on the line
    RangeLimits limits{};                ///< written into the scans
  };

  explicit ScanStream(const Format& format)
      : LidarScanStream(std::make_unique<StreamDecoder>(format.type, format.sample_time, format.byte_time),
                        {.sample_time = format.sample_time,
                         .byte_time = format.byte_time,
                         .limits = {format.limits.min, format.limits.max},
                         .boot_text = kBootText}) {}

  const DecoderCounters& counters() const { return static_cast<const StreamDecoder&>(decoder()).counters(); }
};

}  // namespace slam::rplidar
