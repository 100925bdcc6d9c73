// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

#include "core/scan.hpp"

namespace slam {

/// Bin whose middle a bearing is nearest to. @param bearing [rad], finite @param bins of a full turn
inline std::size_t bearingBin(double bearing, std::size_t bins) {
  const double turns = bearing / (2.0 * std::numbers::pi);
  return static_cast<std::size_t>(std::lround(static_cast<double>(bins) * (turns - std::floor(turns)))) % bins;
}

/// The shortest range within the limits in each bin of the bearings [m]; 0: none.
template <std::size_t bins>
void shortestRanges(std::span<const Beam> beams, const RangeLimits& limits, std::array<float, bins>& ranges) {
  ranges.fill(0.0F);
  for (const Beam& beam : beams) {
    if (!limits.contains(beam.range) || !std::isfinite(beam.bearing)) continue;
    float& range = ranges[bearingBin(beam.bearing, bins)];
    range = range > 0.0F ? std::min(range, beam.range) : beam.range;
  }
}

}  // namespace slam
