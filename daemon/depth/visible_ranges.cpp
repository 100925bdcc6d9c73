// SPDX-License-Identifier: BSD-3-Clause
#include "depth/visible_ranges.hpp"

#include <algorithm>
#include <limits>

namespace slam {
namespace {

constexpr double kMinValid = 0.5;  // [1] share of a band's pixels with depth: the others are dropouts
constexpr double kNever = std::numeric_limits<double>::infinity();

}  // namespace

VisibleRanges::VisibleRanges(std::span<const DepthRays::Band> bands, std::span<const int> valid,
                             const HeightWindow& window) {
  double lowest = 0.0, highest = 0.0;  // [1] slopes
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const DepthRays::Band& band = bands[i];
    if (band.pixels == 0) continue;
    lowest = std::min(lowest, band.slope_low - window.lift);
    highest = std::max(highest, band.slope_high - window.lift);
    if (valid[i] < kMinValid * band.pixels) addBlind(band, window);
  }
  std::sort(blind_.begin(), blind_.begin() + static_cast<std::ptrdiff_t>(blind_count_),
            [](const RangeInterval& a, const RangeInterval& b) { return a.from < b.from; });
  const double floor_from = lowest < 0.0 ? window.down / -lowest : kNever;
  const double top_from = window.up <= 0.0 ? 0.0 : highest > 0.0 ? window.up / highest : kNever;
  covered_from_ = std::max({window.range_min, floor_from, top_from});
}

void VisibleRanges::addBlind(const DepthRays::Band& band, const HeightWindow& window) {
  const double low = band.slope_low - window.lift, high = band.slope_high - window.lift;
  // Its rays are between the two heights from the first to the last of the distances where a border ray crosses one.
  RangeInterval interval{0.0, kNever};
  if (window.up < 0.0) interval.from = low < 0.0 ? -window.up / -low : kNever;
  if (low > 0.0) interval.to = std::max(0.0, window.up / low);
  if (high < 0.0) interval.to = window.down / -high;
  if (interval.from < interval.to) blind_[blind_count_++] = interval;
}

double VisibleRanges::freeBefore(double range) const {
  double from = covered_from_;
  for (const RangeInterval& blind : std::span(blind_).first(blind_count_)) {
    if (blind.from < range) from = std::max(from, blind.to);
  }
  return std::min(from, range);
}

VisibleRanges::RangeInterval VisibleRanges::freeInterval(double range_max) const {
  RangeInterval free{covered_from_, range_max};
  for (const RangeInterval& blind : std::span(blind_).first(blind_count_)) {
    if (blind.from > free.from) return {free.from, std::min(free.to, blind.from)};
    free.from = std::max(free.from, blind.to);
  }
  return free;
}

}  // namespace slam
