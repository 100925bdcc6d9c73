// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/stats.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
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
  char text[2048];
  std::snprintf(text, sizeof text,
                "{\"scans\": %u, \"keyframes\": %u, \"loop_closures\": %d, \"log_s\": %.3f, \"wall_s\": %.3f, "
                "\"cpu_s\": %.3f, \"peak_rss_mb\": %.1f,\n"
                " \"match_us\": {\"p50\": %.1f, \"p99\": %.1f, \"max\": %.1f},\n"
                " \"scan_us\": {\"p50\": %.1f, \"p99\": %.1f, \"max\": %.1f},\n"
                " \"optimise_ms\": {\"p50\": %.3f, \"max\": %.3f},\n"
                " \"matched\": %u, \"partly_observable\": %u, \"unmatched\": %u, \"gated\": %u, \"searched\": %u, "
                "\"lost\": %u, \"relocalised\": %d, \"begun_anew\": %d, \"revoked\": %d, "
                "\"wheels_withdrawn\": %u, \"wheels_scale\": %.4f, \"scans_held\": %u, \"scans_too_late\": %u, "
                "\"scans_repeated\": %u, "
                "\"scans_retimed\": %u, \"clock_resets\": %u, \"samples_late\": %u, \"samples_too_old\": %u,\n"
                " \"rejected_messages\": %llu, \"skipped_bytes\": %llu, \"truncated\": %s,\n",
                localizer.scans, localizer.keyframes, loop_closures, log_s, wall_s, cpu_s, peak_rss_mb, match.p50,
                match.p99, match.max, scan.p50, scan.p99, scan.max, optimise.p50, optimise.max, localizer.matched,
                localizer.partly_observable, localizer.unmatched, localizer.gated, localizer.searched, localizer.lost,
                relocalised, begun_anew, revoked, localizer.wheels_withdrawn, localizer.wheels_scale,
                localizer.scans_held, localizer.scans_too_late, localizer.scans_repeated, localizer.scans_retimed,
                localizer.clock_resets, localizer.samples_late, localizer.samples_too_old,
                static_cast<unsigned long long>(rejected_messages), static_cast<unsigned long long>(skipped_bytes),
                truncated ? "true" : "false");
  char offset[80] = " \"lidar_gyro_offset_s\": null,\n";
  if (lidar_gyro_offset) {
    std::snprintf(offset, sizeof offset, " \"lidar_gyro_offset_s\": %.4f, \"lidar_gyro_offset_sigma_s\": %.4f,\n",
                  lidar_gyro_offset->offset, lidar_gyro_offset->sigma);
  }
  std::string list;  // no text holds a quotation mark or a backslash
  for (const std::string& warning : warnings) list += (list.empty() ? "\"" : ", \"") + warning + "\"";
  return text + std::string(offset) + (" \"warnings\": [" + list + "]}\n");
}

}  // namespace slam
