// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/log_truth.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "relocalisation/global_search.hpp"
#include "relocalisation/place_fit.hpp"

namespace slam {
namespace {

constexpr int kPlaces = 50;           // that are compared
constexpr std::size_t kQuery = 1000;  // points of the log's own map that places are searched for
constexpr GlobalSearchConfig kCoarse{.cell = 0.2, .kernel_sigma = 0.5};  // a whole map may be bent by so much
constexpr double kPart = 2.0;                                            // [m] of path
const Eigen::Vector3d kBendSigma(0.1, 0.1, 0.01);                        // [m, m, rad] of both maps, a part long
constexpr double kNear = 3.0;                                            // [m]
constexpr double kRayWeight = 0.5;                                       // beams at one wall are not independent
constexpr std::array kBlurs{0.5, 0.25, 0.1};                             // [m]
// Of the given map against the log: a lidar and the wheels that a map was made with differ by a percent or two.
constexpr std::array kScales{0.97, 0.975, 0.98, 0.985, 0.99, 0.995, 1.005, 1.01, 1.015, 1.02, 1.025, 1.03};
constexpr int kSweeps = 5;
constexpr double kTurn = 0.1;       // [rad/m] of a step
constexpr double kElsewhere = 0.5;  // [m]

/// A scan as the log's own map places it.
struct AnchoredRow {
  Timestamp stamp;
  AnchoredPose anchored;
};

/// Makes the log's own map. @return its rows, one a scan
std::vector<AnchoredRow> mapLog(const std::vector<LogSample>& samples, Pipeline& pipeline) {
  std::vector<AnchoredRow> rows;
  Timestamp recorded;
  pipeline.on_scan = [&](const ScanOutcome& outcome) {
    rows.push_back({recorded, pipeline.frontEnd().anchor(pipeline.frontEnd().estimate(outcome.stamp).T_map_base)});
  };
  for (const LogSample& sample : samples) {
    if (const auto* scan = std::get_if<std::unique_ptr<LaserScan>>(&sample)) recorded = (*scan)->stamp;
    addTo(pipeline, sample);
  }
  pipeline.on_scan = nullptr;
  return rows;
}

/// The parts that lie near each other in the log's own map, whenever they were driven: the given map bends all of a
/// place alike.
using Neighbours = std::vector<std::vector<std::size_t>>;

Neighbours neighbours(const QueryCloud& whole) {
  Neighbours near(whole.parts.size());
  for (std::size_t i = 0; i < near.size(); ++i) {
    for (std::size_t k = 0; k < near.size(); ++k) {
      const Pose2 apart = between(whole.parts[i].T_newest_part, whole.parts[k].T_newest_part);
      if (i != k && (std::hypot(apart.x, apart.y) < kNear || i == k + 1 || k == i + 1)) near[i].push_back(k);
    }
  }
  return near;
}

/// A whole path laid into the map, part by part: both maps are bent.
struct LaidPath {
  std::vector<Pose2> T_map_part;
  double log_likelihood = 0.0;
  double seen = 0.0;  // [1]
};

double logBend(const QueryCloud& whole, const LaidPath& path, std::size_t i, const Pose2& T_map_i, std::size_t k) {
  const Pose2 T_i_k = between(whole.parts[i].T_newest_part, whole.parts[k].T_newest_part);
  const Pose2 off = between(T_map_i * T_i_k, path.T_map_part[k]);
  return -0.5 * Eigen::Vector3d(off.x, off.y, off.theta).cwiseQuotient(kBendSigma).squaredNorm();
}

double logEnds(const DecayRateMap& field, const QueryCloud::Part& part, const Pose2& T_map_part) {
  double sum = 0.0;
  for (const QueryCloud::Ray& ray : part.rays) sum += field.logRate(T_map_part * ray.to, ray.range);
  return kRayWeight * sum;
}

/// Moves each part to where its beams end most likely, as far as its neighbours let it.
void smooth(const DecayRateMap& field, const QueryCloud& whole, const Neighbours& near, double step, LaidPath& path) {
  for (std::size_t i = 0; i < path.T_map_part.size(); ++i) {
    Pose2 best = path.T_map_part[i];
    double highest = -std::numeric_limits<double>::infinity();
    for (int k = 0; k < 27; ++k) {
      const Pose2 T =
          path.T_map_part[i] * Pose2{step * (k % 3 - 1), step * (k / 3 % 3 - 1), kTurn * step * (k / 9 - 1)};
      double log_likelihood = logEnds(field, whole.parts[i], T);
      for (const std::size_t other : near[i]) log_likelihood += logBend(whole, path, i, T, other);
      if (log_likelihood <= highest) continue;
      highest = log_likelihood;
      best = T;
    }
    path.T_map_part[i] = best;
  }
}

/// Lays the path as it is, then lets it bend: first to walls that are blurred, so that it is drawn to them from afar.
/// @param fields coarsest first
LaidPath lay(std::span<const DecayRateMap> fields, const QueryCloud& whole, const Pose2& T_map_newest) {
  const Neighbours near = neighbours(whole);
  LaidPath path;
  for (const QueryCloud::Part& part : whole.parts) path.T_map_part.push_back(T_map_newest * part.T_newest_part);
  for (const DecayRateMap& field : fields) {
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      for (const double share : {1.0, 0.5, 0.25}) smooth(field, whole, near, share * field.model().sigma, path);
    }
  }
  std::size_t rays = 0, seen = 0;
  for (std::size_t i = 0; i < whole.parts.size(); ++i) {
    path.log_likelihood += logEnds(fields.back(), whole.parts[i], path.T_map_part[i]);
    for (const std::size_t k : near[i]) {
      path.log_likelihood += k < i ? logBend(whole, path, i, path.T_map_part[i], k) : 0.0;
    }
    for (const QueryCloud::Ray& ray : whole.parts[i].rays) {
      seen += fields.back().atWall(fields.back().logRate(path.T_map_part[i] * ray.to, ray.range)) ? 1 : 0;
    }
    rays += whole.parts[i].rays.size();
  }
  path.seen = static_cast<double>(seen) / static_cast<double>(std::max<std::size_t>(1, rays));
  return path;
}

/// The path, were all its ways longer.
QueryCloud stretched(QueryCloud whole, double scale) {
  for (QueryCloud::Part& part : whole.parts) {
    part.T_newest_part.x *= scale;
    part.T_newest_part.y *= scale;
  }
  return whole;
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

std::optional<ScanOutcome> addTo(Pipeline& pipeline, const LogSample& sample) {
  if (const auto* wheels = std::get_if<WheelSample>(&sample)) pipeline.add(*wheels);
  if (const auto* imu = std::get_if<ImuSample>(&sample)) pipeline.add(*imu);
  const auto* scan = std::get_if<std::unique_ptr<LaserScan>>(&sample);
  return scan != nullptr ? std::optional(pipeline.add(**scan)) : std::nullopt;
}

LogTruth fitLog(const std::vector<LogSample>& samples, const Config& config, const MapState& map) {
  Config mapping = config;
  mapping.mode = RunMode::kSlam;
  PipelineConfig fitting = fitted({frontEndConfig(mapping), backEndConfig(mapping), mapping.map, false}, map);
  fitting.back_end.relocalisation.places.model = scanMapModel();  // which its own map is
  const auto own = std::make_unique<Pipeline>(fitting);
  const std::vector<AnchoredRow> rows = mapLog(samples, *own);
  if (rows.empty()) throw std::runtime_error("the log holds no scans");

  std::vector<int> ids(static_cast<std::size_t>(map.keyframes.size()));
  std::iota(ids.begin(), ids.end(), 0);
  std::vector<DecayRateMap> fields;
  for (const double sigma : kBlurs) {
    fields.emplace_back(map.keyframes, ids, BeamModel{.sigma = sigma, .extrapolated_rate = 0.0}, map.kind);
  }
  const KeyframeGraph& keyframes = own->backEnd().keyframes();
  const int newest = keyframes.size() - 1;
  QueryCloud whole;
  whole.gather(keyframes, 0, newest, std::numeric_limits<double>::infinity(), kPart, 0.0);
  std::vector<Eigen::Vector2d> query, all;
  for (const QueryCloud::Part& part : whole.parts) {
    for (const QueryCloud::Ray& ray : part.rays) all.push_back(part.T_newest_part * ray.to);
  }
  for (std::size_t i = 0; i < kQuery; ++i) query.push_back(all[i * all.size() / kQuery]);
  std::vector<LaidPath> paths;
  const GlobalSearch search([&](const auto& visit) { forEachWallPoint(map.keyframes, ids, visit); }, kCoarse);
  for (const GlobalPlace& place : search.search(query, 0.3, kPlaces, 0.5)) {
    paths.push_back(lay(fields, whole, place.T_map_query));
  }
  if (paths.empty()) throw std::runtime_error("the log's own map fits nowhere in the given one");
  std::sort(paths.begin(), paths.end(),
            [](const auto& a, const auto& b) { return a.log_likelihood > b.log_likelihood; });
  LaidPath best = paths.front();
  for (const double scale : kScales) {
    const LaidPath path = lay(fields, stretched(whole, scale), paths.front().T_map_part.front());
    if (path.log_likelihood > best.log_likelihood) best = path;
  }
  LogTruth truth{.rows = {}, .seen = best.seen, .margin = std::numeric_limits<double>::infinity()};
  for (const LaidPath& path : paths) {
    const Pose2 apart = between(path.T_map_part.front(), paths.front().T_map_part.front());
    if (std::hypot(apart.x, apart.y) < kElsewhere) continue;
    truth.margin = std::min(truth.margin, paths.front().log_likelihood - path.log_likelihood);
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
