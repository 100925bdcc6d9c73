// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slam/localizer.hpp"
#include "tools/replay/time_offset.hpp"

namespace slam {

struct Quantiles {
  double p50 = 0.0, p99 = 0.0, max = 0.0;
};
Quantiles quantiles(std::vector<double> values);

/// What slam-replay --stats writes.
struct ReplayStats {
  LocalizerCounters localizer;
  int loop_closures = 0, revoked = 0;  ///< closures that stand, and that were taken back
  int relocalised = 0;                 ///< times that a lost robot was found in the map
  int begun_anew = 0;                  ///< times that a map of a few keyframes was forgotten
  double log_s = 0.0, wall_s = 0.0, cpu_s = 0.0, peak_rss_mb = 0.0;
  std::vector<double> match_us, scan_us;
  std::vector<double> optimise_ms;      ///< of each closure: search, optimisation, reference anew
  std::uint64_t rejected_messages = 0;  ///< that did not decode
  std::uint64_t skipped_bytes = 0;      ///< of the log that belong to no record
  bool truncated = false;
  std::optional<LidarGyroOffset::Estimate> lidar_gyro_offset;  ///< what is left of it with the configured one
  std::vector<std::string> warnings;                           ///< of sensors that contradict each other, one line each

  std::string json() const;
};

}  // namespace slam
