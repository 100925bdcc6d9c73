// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/scan_pairs.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <numbers>
#include <random>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "matching/correlative.hpp"
#include "matching/deskew.hpp"
#include "matching/icp.hpp"
#include "matching/normals.hpp"
#include "matching/plicp.hpp"
#include "tools/eval/metrics.hpp"

namespace slam {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kSuccessTranslation = 0.10, kSuccessRotation = 2.0;  // [m], [deg]
constexpr auto kSameStamp = std::chrono::milliseconds(2);

struct RecordedScan {
  ScanPoints points;
  Pose2 T_wheels_base;
};

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(q * static_cast<double>(values.size())))];
}

/// The scan nearest to the stamp: some lie only a millisecond apart.
const RecordedScan* find(const std::map<Timestamp, RecordedScan>& scans, Timestamp stamp) {
  auto nearest = scans.lower_bound(stamp);
  if (nearest == scans.end() ||
      (nearest != scans.begin() && stamp - std::prev(nearest)->first < nearest->first - stamp)) {
    if (nearest == scans.begin()) return nullptr;
    --nearest;
  }
  return std::chrono::abs(nearest->first - stamp) <= kSameStamp ? &nearest->second : nullptr;
}

}  // namespace

std::vector<ScanPair> loadScanPairs(const std::filesystem::path& log, const std::filesystem::path& relations,
                                    const Config& config, double max_interval) {
  const LidarModel& lidar = config.front_end.lidar;
  NormalConfig normals = config.front_end.preprocessor.normals;
  normals.range_sigma = lidar.range_sigma;
  std::map<Timestamp, RecordedScan> scans;
  Pose2 wheels;
  EventLogReader reader(log);
  for (LogEvent event; reader.next(event);) {
    if (event.channel == channel::kWheels) {
      const auto message = decodeChecked<wheels_t>(event.data);
      if (const auto sample = message ? fromMessage(*message) : std::nullopt) wheels = sample->T_wheels_base;
    } else if (event.channel == channel::kScan) {
      const auto message = decodeChecked<scan_t>(event.data);
      const auto scan = message ? fromMessage(*message) : std::nullopt;
      if (!scan) continue;
      RecordedScan& recorded = scans[scan->stamp];
      recorded.T_wheels_base = wheels;
      deskew(*scan, {static_cast<float>(lidar.range_min), static_cast<float>(lidar.range_max)}, scan->stamp,
             lidar.mounting(), PoseHistory(2), recorded.points);
      estimateNormals(recorded.points, lidar.T_base_lidar.translation(), normals);
    }
  }
  std::vector<ScanPair> pairs;
  for (const Relation& relation : readRelations(relations)) {
    const RecordedScan *from = find(scans, relation.from), *to = find(scans, relation.to);
    if (!from || !to || std::abs(toSeconds(relation.to - relation.from)) >= max_interval) continue;
    pairs.push_back({from->points, to->points, relation.T_from_to, between(from->T_wheels_base, to->T_wheels_base)});
  }
  return pairs;
}

PairReport matchPairs(const std::vector<ScanPair>& pairs, Matcher matcher, double translation_noise,
                      double rotation_noise, std::uint64_t seed, const Config& config) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  MatchConfig match = config.front_end.match;
  match.range_sigma = config.front_end.lidar.range_sigma;
  match.search_translation = translation_noise;
  match.search_rotation = rotation_noise;
  Reference reference(config.front_end.reference);
  CorrelativeMatcher search;
  const SearchWindow window{translation_noise, rotation_noise};

  PairReport report;
  int successes = 0;
  std::vector<double> translations, rotations, iterations, times;
  for (const ScanPair& pair : pairs) {
    reference.clear();
    reference.add(Pose2{}, pair.reference);
    const Pose2 guess{pair.guess.x + translation_noise * uniform(random),
                      pair.guess.y + translation_noise * uniform(random),
                      wrapAngle(pair.guess.theta + rotation_noise * uniform(random))};
    const auto begin = std::chrono::steady_clock::now();
    const MatchResult result = matcher == Matcher::kPointToPoint ? matchPointToPoint(reference, pair.scan, guess, match)
                               : matcher == Matcher::kPointToLine
                                   ? matchPointToLine(reference, pair.scan, guess, match)
                                   : search.matchOrSearch(reference, pair.scan, guess, window, match).match;
    times.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
    iterations.push_back(result.iterations);
    const Pose2 error = between(pair.T_ref_scan, result.T_ref_base);
    const double translation = std::hypot(error.x, error.y), rotation = std::abs(error.theta) * kDegrees;
    if (translation < kSuccessTranslation && rotation < kSuccessRotation) {
      ++successes;
      translations.push_back(translation);
      rotations.push_back(rotation);
    } else {
      ++report.wrong;
      if (result.status != MatchStatus::kConverged) ++report.wrong_refused;
    }
  }
  const double count = static_cast<double>(std::max<std::size_t>(1, pairs.size()));
  report.success = successes / count;
  report.wrong_converged = (report.wrong - report.wrong_refused) / count;
  report.median_translation = quantile(translations, 0.5);
  report.median_rotation = quantile(rotations, 0.5);
  report.median_iterations = quantile(iterations, 0.5);
  report.p99_iterations = quantile(iterations, 0.99);
  report.median_us = quantile(times, 0.5);
  report.p99_us = quantile(times, 0.99);
  return report;
}

}  // namespace slam
