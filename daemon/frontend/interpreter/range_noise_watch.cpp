// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/range_noise_watch.hpp"

#include <algorithm>
#include <cmath>

#include "frontend/interpreter/bearing_bins.hpp"

namespace slam {

void RangeNoiseWatch::add(std::span<const Beam> beams, const RangeLimits& limits, bool at_rest) {
  if (!at_rest) {
    at_rest_ = 0;
    return;
  }
  std::rotate(scans_.begin(), scans_.end() - 1, scans_.end());
  shortestRanges(beams, limits, scans_.front());
  if (++at_rest_ < static_cast<int>(scans_.size())) return;
  const auto sigma = measure();
  if (!sigma) return;
  std::rotate(newest_.begin(), newest_.end() - 1, newest_.end());
  newest_.front() = *sigma;
}

std::optional<double> RangeNoiseWatch::measure() {
  std::size_t size = 0;
  for (std::size_t bin = 0; bin < scans_[0].size(); ++bin) {
    const float a = scans_[0][bin], b = scans_[1][bin], c = scans_[2][bin];
    if (a > 0.0F && b > 0.0F && c > 0.0F) spreads_[size++] = {a + b + c, std::abs(a - 2.0F * b + c)};
  }
  if (size < static_cast<std::size_t>(config_.fewest)) return std::nullopt;
  const auto first = spreads_.begin(), nearer = first + static_cast<std::ptrdiff_t>(size / 2);
  std::nth_element(first, nearer, first + static_cast<std::ptrdiff_t>(size),
                   [](const Spread& x, const Spread& y) { return x.range < y.range; });
  const auto median = first + static_cast<std::ptrdiff_t>(size / 4);
  std::nth_element(first, median, nearer, [](const Spread& x, const Spread& y) { return x.difference < y.difference; });
  return median->difference / (0.6745 * std::sqrt(6.0));  // median of a normal distribution; 1 + 4 + 1 variances
}

}  // namespace slam
