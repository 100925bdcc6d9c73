// SPDX-License-Identifier: BSD-3-Clause
#include "slam/merge/map_merge.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "graph/align_map.hpp"
#include "relocalisation/loop_closure.hpp"

namespace slam {
namespace {

using Outcome = MergeReport::Outcome;

/// Keyframes of both maps; those of the second one behind the others, laid at a place of the first.
KeyframeGraph jointGraph(const MapState& first, const MapState& second, const Pose2& T_first_second) {
  KeyframeGraph joint = first.keyframes;  // scans are shared
  const int offset = joint.size();
  for (int id = 0; id < second.keyframes.size(); ++id)
    joint.add(second.keyframes.scan(id), T_first_second * second.keyframes.pose(id));
  for (Edge edge : second.keyframes.graph().edges()) {
    edge.from += offset;
    edge.to += offset;
    joint.graph().addEdge(edge);
  }
  return joint;
}

std::vector<int> idsInMap(const MapState& map, int offset) {
  std::vector<int> ids;
  for (int id = 0; id < map.keyframes.size(); ++id) {
    if (map.in_map[static_cast<std::size_t>(id)] != 0) ids.push_back(id + offset);
  }
  return ids;
}

bool sharesKeyframes(const MapState& first, const MapState& second) {
  const auto keyOf = [](const StoredScan& scan) {
    const Keyframe::Point point = scan.points.empty() ? Keyframe::Point{} : scan.points.front();
    return std::tuple(scan.stamp, scan.points.size(), point.x, point.y);
  };
  std::set<std::tuple<Timestamp, std::size_t, float, float>> known;
  for (int id = 0; id < first.keyframes.size(); ++id) known.insert(keyOf(wholeScan(first, id)));
  for (int id = 0; id < second.keyframes.size(); ++id) {
    if (known.contains(keyOf(wholeScan(second, id)))) return true;
  }
  return false;
}

Outcome outcomeOf(RegisteredMap::Outcome registered) {
  switch (registered) {
    case RegisteredMap::Outcome::kFound:
      return Outcome::kMerged;
    case RegisteredMap::Outcome::kAmbiguous:
      return Outcome::kAmbiguous;
    case RegisteredMap::Outcome::kContradictory:
      return Outcome::kContradictory;
    case RegisteredMap::Outcome::kNowhere:
      break;
  }
  return Outcome::kNowhere;
}

/// Furniture that was moved pulls a match: no second one has to agree with those that this leaves.
LoopClosureConfig sure(LoopClosureConfig config) {
  config.min_overlap = config.sure_overlap;
  return config;
}

/// Two maps while they are joined.
class Joining {
 public:
  Joining(KeyframeGraph joint, std::vector<int> first, std::vector<int> second, const BackEndConfig& config,
          const MergeConfig& merge)
      : keyframes(std::move(joint)),
        first_(std::move(first)),
        second_(std::move(second)),
        config_(config),
        merge_(merge),
        closures_(sure(config.closure), config.relocalisation.places, config.reference, config.match) {
    for (const int id : first_) T_first_.push_back(keyframes.pose(id));
    before_.assign(keyframes.graph().poses().begin(), keyframes.graph().poses().end());
  }

  /// A keyframe of the second map that may lie here. @return the closure; none where no keyframe is near, or it does
  /// not match
  std::optional<Edge> closure(int id, const Pose2& T_map_id, bool* near) {
    const Pose2& here = T_map_id;
    const auto unlikeness = [&](int other) {
      const Pose2& pose = keyframes.pose(other);
      return (pose.translation() - here.translation()).norm() + 1.0 - std::cos(pose.theta - here.theta);
    };
    std::vector<int> candidates = keyframes.near(here.translation(), merge_.closure_distance);
    std::erase_if(candidates, [&](int other) { return !std::binary_search(first_.begin(), first_.end(), other); });
    *near = !candidates.empty();
    if (candidates.empty()) return std::nullopt;
    const int nearest = *std::min_element(candidates.begin(), candidates.end(),
                                          [&](int a, int b) { return unlikeness(a) < unlikeness(b); });
    return closures_.verify(keyframes, id, {nearest, T_map_id, {config_.closure.min_search, config_.closure.min_turn}});
  }

  /// Closures of the keyframes that were found by themselves; they bend the second map to the first.
  void tie(std::span<const RegisteredMap::Found> found) {
    std::vector<Edge> edges;
    for (const auto& [id, T_map_id] : found) {
      bool near = false;
      if (const auto edge = closure(id, T_map_id, &near)) edges.push_back(*edge);
    }
    if (edges.empty()) return;
    MergeReport unused;
    const KeyframeGraph bent = optimised(edges, unused);
    for (int id = 0; id < bent.size(); ++id) keyframes.graph().setPose(id, bent.pose(id));
  }

  /// Closures of all keyframes of the second map that lie near one of the first.
  std::vector<Edge> tieAll(MergeReport& report, const std::function<void(double)>& progress) {
    std::vector<Edge> edges;
    double path = merge_.closure_spacing;
    for (std::size_t i = 0; i < second_.size(); ++i) {
      const Pose2& here = keyframes.pose(second_[i]);
      if (i > 0) path += (here.translation() - keyframes.pose(second_[i - 1]).translation()).norm();
      if (path < merge_.closure_spacing) continue;
      path = 0.0;
      bool near = false;
      if (const auto edge = closure(second_[i], here, &near)) edges.push_back(*edge);
      report.near += near ? 1 : 0;
      if (progress) progress(static_cast<double>(i) / static_cast<double>(second_.size()));
    }
    report.verified = static_cast<int>(edges.size());
    std::vector<Edge> kept;
    std::copy_if(edges.begin(), edges.end(), std::back_inserter(kept),
                 [&](const Edge& edge) { return isConsistent(edge, edges); });
    report.revoked = report.verified - static_cast<int>(kept.size());
    return kept;
  }

  /// Whether most closures around one agree with it, by what either map knew of the ways between them.
  bool isConsistent(const Edge& edge, std::span<const Edge> edges) const {
    int agreeing = 0, others = 0;
    const auto before = [&](int id) { return before_[static_cast<std::size_t>(id)]; };
    for (const Edge& other : edges) {
      const Pose2 way = between(before(edge.to), before(other.to));
      const double length = way.translation().norm();
      if (other.to == edge.to || length > merge_.consistent_within) continue;
      ++others;
      const Pose2 there = edge.T_from_to * way, back = between(before(edge.from), before(other.from)) * other.T_from_to;
      const Pose2 gap = between(there, back);
      agreeing += gap.translation().norm() < merge_.consistency + merge_.bend * length &&
                  std::abs(gap.theta) < merge_.consistent_turn;
    }
    return 2 * agreeing >= others;
  }

  /// The graph with these closures, at its optimum, without those that the others contradict, and laid where the first
  /// map was. @param report out: revoked, residual
  KeyframeGraph optimised(std::span<const Edge> edges, MergeReport& report) const {
    KeyframeGraph tied = keyframes;
    PoseGraph& graph = tied.graph();
    std::vector<int> added;
    for (const Edge& edge : edges) added.push_back(graph.addEdge(edge));
    Optimiser optimiser(config_.optimiser);
    const auto chiSquareOf = [&](int id) {
      const Edge& edge = graph.edges()[static_cast<std::size_t>(id)];
      return edge.revoked ? 0.0 : chiSquare(edge, graph.pose(edge.from), graph.pose(edge.to));
    };
    for (;; ++report.revoked) {
      optimiser.optimise(graph);
      const auto worst =
          std::max_element(added.begin(), added.end(), [&](int a, int b) { return chiSquareOf(a) < chiSquareOf(b); });
      if (worst == added.end() || chiSquareOf(*worst) <= config_.closure.max_chi_square) break;
      graph.revoke(*worst);
    }
    double squares = 0.0;
    int standing = 0;
    for (const int id : added) {
      const Edge& edge = graph.edges()[static_cast<std::size_t>(id)];
      const Pose2 gap = between(graph.pose(edge.from) * edge.T_from_to, graph.pose(edge.to));
      if (edge.revoked) continue;
      squares += gap.translation().squaredNorm();
      ++standing;
    }
    report.residual = std::sqrt(squares / std::max(1, standing));
    std::vector<Pose2> T_new;
    for (const int id : first_) T_new.push_back(graph.pose(id));
    const Pose2 T_map_new = alignToPreviousMap(T_first_, T_new);
    for (int id = 0; id < graph.size(); ++id) graph.setPose(id, T_map_new * graph.pose(id));
    return tied;
  }

  KeyframeGraph keyframes;  ///< without the closures

 private:
  std::vector<int> first_, second_;  // ids of the keyframes in the maps
  std::vector<Pose2> T_first_;       // of the first map's keyframes, as they were
  std::vector<Pose2> before_;        // of all keyframes, by id, before any closure
  const BackEndConfig& config_;
  const MergeConfig& merge_;
  LoopClosureSearch closures_;
};

/// Whether the obstacles of both maps are the same, or those that differ look like furniture that was moved.
/// @param report out: cells, furniture
bool haveOneFloor(const KeyframeGraph& keyframes, std::span<const int> first, std::span<const int> second,
                  OccupancyGridConfig grid, const MergeConfig& merge, MergeReport& report) {
  const auto drawn = [&](std::span<const int> ids, double cell) {
    grid.resolution = cell;
    OccupancyGrid map(grid);
    for (const int id : ids) map.add(keyframes.pose(id), keyframes.scan(id)->T_base_lidar, keyframes.scan(id)->points);
    return map;
  };
  const double coarse = merge.compared_cell, fine = merge.furniture.cell;
  report.cells = compareCells(drawn(first, coarse), drawn(second, coarse), merge.cell_tolerance);
  if (merge.furniture_moved || report.cells.share() >= merge.min_same_cells) return true;
  report.furniture = findMovedFurniture(drawn(first, fine), drawn(second, fine), merge.furniture);
  return report.furniture.evidence >= merge.min_moved;
}

/// Both maps with these poses and edges. @param turn [rad] of the second one's axes
MapState joined(const MapState& first, const MapState& second, KeyframeGraph keyframes, double turn,
                OccupancyGridConfig grid) {
  MapState map = first.clone();
  const int offset = first.keyframes.size();
  map.keyframes = std::move(keyframes);
  map.in_map.insert(map.in_map.end(), second.in_map.begin(), second.in_map.end());
  for (MapView view : second.views) {
    view.keyframe += offset;
    view.edit += first.edits.made;
    map.views.push_back(view);
  }
  map.edits.append(second.edits, offset, turn);
  eraseFrom(map.keyframes, map.edits);
  map.range_max = std::max(first.range_max, second.range_max);
  map.utime = std::max(first.utime, second.utime);
  grid.resolution = first.grid.resolution();
  map.grid = drawGrid(map, grid);
  map.grid_keyframes = map.keyframes.size();
  return map;
}

std::ptrdiff_t activeEdits(const MapState& map) {
  return std::count_if(map.edits.edits.begin(), map.edits.edits.end(), [](const MapEdit& edit) { return edit.active; });
}

}  // namespace

MapState jointMap(const MapState& first, const MapState& second, const Pose2& T_first_second,
                  const OccupancyGridConfig& grid) {
  return joined(first, second, jointGraph(first, second, T_first_second), T_first_second.theta, grid);
}

MergedMap mergeMaps(const MapState& first, const MapState& second, const BackEndConfig& config,
                    const OccupancyGridConfig& grid, MergeConfig merge, const std::function<void(double)>& progress) {
  const auto part = [&](double begin, double size) -> std::function<void(double)> {
    if (!progress) return {};
    return [&progress, begin, size](double share) { progress(begin + size * share); };
  };
  MergedMap merged;
  MergeReport& report = merged.report;
  const std::vector<int> in_first = idsInMap(first, 0), in_second = idsInMap(second, first.keyframes.size());
  if (in_first.empty() || in_second.empty() || first.kind != MapKind::kScans || second.kind != MapKind::kScans) {
    report.outcome = Outcome::kNoKeyframes;
    return merged;
  }
  if (sharesKeyframes(first, second)) {
    report.outcome = Outcome::kShared;
    return merged;
  }
  if (activeEdits(first) + activeEdits(second) > static_cast<std::ptrdiff_t>(kEditLimits.edits)) {
    report.outcome = Outcome::kTooManyEdits;
    return merged;
  }
  merge.registration.places = config.relocalisation.places;
  const KeyframeGraph apart = jointGraph(first, second, Pose2{});
  report.registration = MapRegistration(apart, in_first, in_second, merge.registration).find(part(0.0, 0.7));
  report.outcome = outcomeOf(report.registration.outcome);
  if (report.outcome != Outcome::kMerged) return merged;

  const Pose2& T_map_second = report.registration.T_map_second;
  Joining joining(jointGraph(first, second, T_map_second), in_first, in_second, config, merge);
  joining.tie(report.registration.found);
  const std::vector<Edge> edges = joining.tieAll(report, part(0.7, 0.3));
  report.outcome = Outcome::kContradictory;
  if (edges.empty()) return merged;
  KeyframeGraph keyframes = joining.optimised(edges, report);
  if (report.verified - report.revoked < merge.min_verified * report.near ||
      report.revoked > merge.max_revoked * report.verified)
    return merged;
  report.outcome = Outcome::kOtherFurniture;
  if (!haveOneFloor(keyframes, in_first, in_second, grid, merge, report)) return merged;
  report.outcome = Outcome::kMerged;
  merged.map = joined(first, second, std::move(keyframes), T_map_second.theta, grid);
  return merged;
}

}  // namespace slam
