// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimation/ekf.hpp"
#include "estimation/lidar_delay.hpp"
#include "frontend/front_end_state.hpp"
#include "slam/back_end.hpp"
#include "slam/refine/map_refinement.hpp"

namespace slam {

struct Quantiles {
  double p50 = 0.0, p99 = 0.0, max = 0.0;
};
Quantiles quantiles(std::vector<double> values);

/// What slam-replay --stats writes.
struct ReplayStats {
  FrontEndCounters front_end;
  EkfCounters filter;
  BackEndCounters back_end;
  double log_s = 0.0, wall_s = 0.0, cpu_s = 0.0, peak_rss_mb = 0.0;
  std::vector<double> match_us, scan_us;
  std::vector<double> optimise_ms;      ///< of each closure: search, optimisation, reference anew
  std::uint64_t rejected_messages = 0;  ///< that are no measurement
  std::vector<std::string> refusals;    ///< why, in words, one line a channel
  std::uint64_t thinned_beams = 0;      ///< left out evenly of scans that have more than are used
  std::uint64_t skipped_bytes = 0;      ///< of the log that belong to no record
  bool truncated = false;
  std::optional<LidarDelay::Estimate> lidar_gyro_offset;  ///< what is left of it with the configured one
  bool turns_differ = false;               ///< by a warning, so that the offset is none that could be set
  bool wheels_died = false;                ///< they reported that they stand while scans showed that the robot moves
  std::optional<RefineReport> refinement;  ///< if it was asked for
  std::vector<std::string> warnings;       ///< of sensors that contradict each other, one line each

  /// Scans that could have been matched.
  std::uint32_t notMatched() const { return front_end.unmatched + front_end.gated + front_end.scans_too_late; }
  std::string json() const;
};

}  // namespace slam
