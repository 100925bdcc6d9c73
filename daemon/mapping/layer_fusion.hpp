// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

/// How one cell's lidar layer and depth layer become one value.
///
/// [Paper] "Indoor Robot SLAM with Multi-Sensor Fusion", section III.B, eq. 18-20 and Table II.
namespace slam {

/// log(p / (1 - p)) in units of 1/kLogOddsScale; 0 is p = 0.5, and a cell that was never seen.
using LogOdds = std::int16_t;
inline constexpr double kLogOddsScale = 1000.0;
/// p = 1: only the paper's fusion gets so sure.
inline constexpr LogOdds kCertain = std::numeric_limits<LogOdds>::max();

inline LogOdds toLogOdds(double probability) {
  return static_cast<LogOdds>(std::lround(kLogOddsScale * std::log(probability / (1.0 - probability))));
}
inline double toProbability(LogOdds log_odds) {
  return log_odds == kCertain ? 1.0 : 1.0 / (1.0 + std::exp(-log_odds / kLogOddsScale));
}

enum class Fusion : std::uint8_t {
  kLayers,  ///< each layer believes its own newest evidence; an obstacle of either is an obstacle
  kPaper,   ///< [Paper]: a cell once more likely occupied than not is occupied for good
};

/// Ours: the rules of Table II, but graded, so that later looks can take back what earlier ones said. The layers look
/// at different heights: free at the lidar's height does not contradict an obstacle above it, so the surer obstacle
/// counts; where neither sees one, the surer emptiness.
inline LogOdds fusedLayers(LogOdds lidar, LogOdds depth) {
  return lidar > 0 || depth > 0 ? std::max(lidar, depth) : std::min(lidar, depth);
}

/// One value of a cell, 0..1 as log-odds.
inline LogOdds fused(Fusion fusion, LogOdds lidar, LogOdds depth) {
  if (fusion == Fusion::kLayers) return fusedLayers(lidar, depth);
  if (lidar > 0 || depth > 0) return kCertain;                           // eq. 19, and eq. 20 with P = 1
  return static_cast<LogOdds>(std::max<int>(lidar + depth, -kCertain));  // eq. 20 in log-odds
}

}  // namespace slam
