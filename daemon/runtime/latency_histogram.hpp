// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <atomic>
#include <cstdint>

#include "core/timestamp.hpp"

namespace slam {

/// Counts durations in buckets of 1/8 octave (at most 9 % wide) from 0.1 us to about 100 s. One writer, any readers;
/// no lock, no allocation.
class LatencyHistogram {
 public:
  void add(Duration duration);

  struct Summary {
    std::int64_t count = 0;
    double p50_us = 0.0, p99_us = 0.0, max_us = 0.0;
  };
  Summary summary() const;

 private:
  static constexpr int kPerOctave = 8, kOctaves = 30;
  static constexpr double kSmallest = 0.1;  // [us] lower edge of bucket 0
  double quantile(double q, std::int64_t count) const;

  std::array<std::atomic<std::uint32_t>, static_cast<std::size_t>(kPerOctave) * kOctaves> buckets_{};
  std::atomic<std::int64_t> count_{0};
  std::atomic<std::int64_t> max_ns_{0};
};

}  // namespace slam
