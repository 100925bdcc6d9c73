// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/log_truth.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "posegraph/global_search.hpp"
#include "posegraph/place_likelihood.hpp"
#include "slam/back_end.hpp"
#include "slam/localizer.hpp"

namespace slam {
namespace {

constexpr int kPlaces = 50;           // that are compared
constexpr std::size_t kQuery = 1000;  // points of the log's own map that places are searched for
constexpr GlobalSearchConfig kCoarse{.cell = 0.2, .kernel_sigma = 0.5};  // a whole map may be bent by so much
constexpr double kPart = 2.0;                                            // [m] of path
constexpr double kElsewhere = 0.5;                                       // [m]

/// A scan as the log's own map places it.
struct AnchoredRow {
  Timestamp stamp;
  Localizer::Anchored anchored;
};

/// Makes the log's own map. @return its rows, one a scan
std::vector<AnchoredRow> mapLog(const std::vector<LogSample>& samples, const Config& config, BackEnd& back_end) {
  Localizer localizer(localizerConfig(config));
  std::vector<AnchoredRow> rows;
  for (const LogSample& sample : samples) {
    if (const auto* wheels = std::get_if<WheelSample>(&sample)) localizer.add(*wheels);
    if (const auto* imu = std::get_if<ImuSample>(&sample)) localizer.add(*imu);
    const auto* scan = std::get_if<std::unique_ptr<LaserScan>>(&sample);
    if (scan == nullptr) continue;
    const ScanOutcome outcome = localizer.add(**scan);
    const Pose2 T_own_base = localizer.estimate(outcome.stamp).T_map_base;
    if (outcome.keyframe != nullptr) back_end.add(*outcome.keyframe);
    rows.push_back({(*scan)->stamp, localizer.anchor(T_own_base)});
    if (auto correction = back_end.takeCorrection()) {
      localizer.apply(*correction);
      back_end.recycle(std::move(correction));
    }
  }
  return rows;
}

/// Lays the whole path from its newest end to the oldest, then back from there, which mends what began badly.
PlaceFit fitThereAndBack(const WallField& field, const SegmentView& whole, const Pose2& T_map_newest) {
  const PlaceFit there = fitPlace(field, whole, T_map_newest);
  SegmentView reversed = whole;
  std::reverse(reversed.parts.begin(), reversed.parts.end());
  PlaceFit back = fitPlace(field, reversed, there.T_map_part.back());
  if (back.log_likelihood < there.log_likelihood) return there;
  std::reverse(back.T_map_part.begin(), back.T_map_part.end());
  back.T_map_newest = back.T_map_part.front();
  return back;
}

}  // namespace

std::vector<LogSample> readSamples(const std::filesystem::path& log) {
  EventLogReader reader(log);
  std::vector<LogSample> samples;
  for (LogEvent event; reader.next(event);) {
    if (event.channel == channel::kScan) {
      const auto message = decodeChecked<scan_t>(event.data);
      if (const auto scan = message ? fromMessage(*message) : std::nullopt) {
        samples.emplace_back(std::make_unique<LaserScan>(*scan));
      }
    } else if (event.channel == channel::kWheels) {
      const auto message = decodeChecked<wheels_t>(event.data);
      if (const auto sample = message ? fromMessage(*message) : std::nullopt) samples.emplace_back(*sample);
    } else if (event.channel == channel::kImu) {
      const auto message = decodeChecked<imu_t>(event.data);
      if (const auto sample = message ? fromMessage(*message) : std::nullopt) samples.emplace_back(*sample);
    }
  }
  return samples;
}

LogTruth fitLog(const std::vector<LogSample>& samples, const Config& config, const MapState& map) {
  Config mapping = config;
  mapping.mode = "slam";
  BackEnd own(backEndConfig(mapping));
  const std::vector<AnchoredRow> rows = mapLog(samples, mapping, own);
  if (rows.empty()) throw std::runtime_error("the log holds no scans");

  std::vector<int> ids(static_cast<std::size_t>(map.keyframes.size()));
  std::iota(ids.begin(), ids.end(), 0);
  const WallField field(map.keyframes, ids);
  const KeyframeGraph& keyframes = own.keyframes();
  const int newest = keyframes.size() - 1;
  SegmentView whole;
  whole.gather(keyframes, 0, newest, std::numeric_limits<double>::infinity(), kPart);
  std::vector<Eigen::Vector2d> query, all;
  for (const SegmentView::Part& part : whole.parts) {
    for (const SegmentView::Ray& ray : part.rays) all.push_back(part.T_newest_part * ray.to);
  }
  for (std::size_t i = 0; i < kQuery; ++i) query.push_back(all[i * all.size() / kQuery]);
  PlaceFit best;
  best.log_likelihood = -std::numeric_limits<double>::infinity();
  std::vector<PlaceFit> fits;
  for (const GlobalPlace& place : GlobalSearch(field.wallPoints(), kCoarse).search(query, 0.3, kPlaces, 0.5)) {
    fits.push_back(fitThereAndBack(field, whole, place.T_map_query));
    if (fits.back().log_likelihood > best.log_likelihood) best = fits.back();
  }
  if (fits.empty()) throw std::runtime_error("the log's own map fits nowhere in the given one");
  LogTruth truth{.rows = {}, .seen = best.seen, .lead = std::numeric_limits<double>::infinity()};
  for (const PlaceFit& fit : fits) {
    if (std::hypot(fit.T_map_newest.x - best.T_map_newest.x, fit.T_map_newest.y - best.T_map_newest.y) < kElsewhere) {
      continue;
    }
    truth.lead = std::min(truth.lead, best.log_likelihood - fit.log_likelihood);
  }
  for (const AnchoredRow& row : rows) {
    const int id = std::max(0, row.anchored.keyframe);
    const auto part = static_cast<std::size_t>(whole.part_of[static_cast<std::size_t>(newest - id)]);
    const Pose2 T_newest_row = between(keyframes.pose(newest), keyframes.pose(id)) * row.anchored.T_keyframe_base;
    truth.rows.push_back({row.stamp, best.T_map_part[part] * between(whole.parts[part].T_newest_part, T_newest_row)});
  }
  return truth;
}

}  // namespace slam
