// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/stats.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <type_traits>

namespace slam {

Quantiles quantiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double q) {  // nearest rank
    const double rank = std::ceil(q * static_cast<double>(values.size()));
    return values[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
  };
  return {at(0.5), at(0.99), values.back()};
}

std::string ReplayStats::json() const {
  const Quantiles match = quantiles(match_us), scan = quantiles(scan_us), optimise = quantiles(optimise_ms);
  char text[1024];
  std::snprintf(text, sizeof text,
                "{\"log_s\": %.3f, \"wall_s\": %.3f, \"cpu_s\": %.3f, \"peak_rss_mb\": %.1f,\n"
                " \"match_us\": {\"p50\": %.1f, \"p99\": %.1f, \"max\": %.1f},\n"
                " \"scan_us\": {\"p50\": %.1f, \"p99\": %.1f, \"max\": %.1f},\n"
                " \"optimise_ms\": {\"p50\": %.3f, \"max\": %.3f},\n"
                " \"rejected_messages\": %llu, \"thinned_beams\": %llu, \"skipped_bytes\": %llu, \"truncated\": %s,\n",
                log_s, wall_s, cpu_s, peak_rss_mb, match.p50, match.p99, match.max, scan.p50, scan.p99, scan.max,
                optimise.p50, optimise.max, static_cast<unsigned long long>(rejected_messages),
                static_cast<unsigned long long>(thinned_beams), static_cast<unsigned long long>(skipped_bytes),
                truncated ? "true" : "false");
  std::string counts;
  const auto add = [&](const CounterInfo& what, const auto& value) {
    char number[32];
    std::snprintf(number, sizeof number, "%.*f", std::is_floating_point_v<std::decay_t<decltype(value)>> ? 4 : 0,
                  static_cast<double>(value));
    counts.append(" \"").append(what.statistic()).append("\": ").append(number).append(",\n");
  };
  visitCounters(front_end, add);
  visitCounters(filter, add);
  visitCounters(back_end, add);
  char offset[80] = " \"lidar_gyro_offset_s\": null,\n";
  if (lidar_gyro_offset) {
    std::snprintf(offset, sizeof offset, " \"lidar_gyro_offset_s\": %.4f, \"lidar_gyro_offset_sigma_s\": %.4f,\n",
                  lidar_gyro_offset->offset, lidar_gyro_offset->sigma);
  }
  const auto listOf = [](const std::vector<std::string>& lines) {  // none holds a quotation mark or a backslash
    std::string list;
    for (const std::string& line : lines) list += (list.empty() ? "\"" : ", \"") + line + "\"";
    return "[" + list + "]";
  };
  return text + counts + offset + " \"refusals\": " + listOf(refusals) + ",\n \"warnings\": " + listOf(warnings) +
         "}\n";
}

}  // namespace slam
