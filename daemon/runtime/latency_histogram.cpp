// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/latency_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace slam {

void LatencyHistogram::add(Duration duration) {
  const double microseconds = static_cast<double>(duration.count()) * 1e-3;
  const double octaves = microseconds > kSmallest ? std::log2(microseconds / kSmallest) : 0.0;
  const auto bucket = static_cast<std::size_t>(octaves * kPerOctave);
  buckets_[std::min(bucket, buckets_.size() - 1)].fetch_add(1, std::memory_order_relaxed);
  if (duration.count() > max_ns_.load(std::memory_order_relaxed)) {
    max_ns_.store(duration.count(), std::memory_order_relaxed);
  }
  count_.fetch_add(1, std::memory_order_release);
}

double LatencyHistogram::quantile(double q, std::int64_t count) const {
  const auto rank = static_cast<std::int64_t>(std::ceil(q * static_cast<double>(count)));
  std::int64_t seen = 0;
  for (std::size_t i = 0; i < buckets_.size(); ++i) {
    seen += buckets_[i].load(std::memory_order_relaxed);
    if (seen >= rank) return kSmallest * std::exp2((static_cast<double>(i) + 0.5) / kPerOctave);
  }
  return static_cast<double>(max_ns_.load(std::memory_order_relaxed)) * 1e-3;
}

LatencyHistogram::Summary LatencyHistogram::summary() const {
  Summary summary;
  summary.count = count_.load(std::memory_order_acquire);
  if (summary.count == 0) return summary;
  summary.max_us = static_cast<double>(max_ns_.load(std::memory_order_relaxed)) * 1e-3;
  summary.p50_us = std::min(summary.max_us, quantile(0.50, summary.count));
  summary.p99_us = std::min(summary.max_us, quantile(0.99, summary.count));
  return summary;
}

}  // namespace slam
