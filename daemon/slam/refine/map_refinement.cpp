// SPDX-License-Identifier: BSD-3-Clause
#include "slam/refine/map_refinement.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "graph/align_map.hpp"
#include "matching/plicp.hpp"

namespace slam {
namespace {

using Outcome = RefineReport::Outcome;
std::size_t at(int id) { return static_cast<std::size_t>(id); }

/// Keyframes in a row, which are matched against as one.
struct Stretch {
  int first, last;
};

/// A keyframe, and the one nearest to it of another visit to its place.
struct Visit {
  int stretch, from, to;
  double unlikeness;  // [m] a lidar that sees half a turn sees the same only in the same direction
};

/// The keyframes of a map while they are refined.
class Refinement {
 public:
  Refinement(const MapState& map, const BackEndConfig& config, const RefineConfig& refine)
      : keyframes(map.keyframes), in_map_(map.in_map), config_(config), refine_(refine), match_(config.match) {
    match_.min_overlap = config.closure.min_overlap;
    ReferenceConfig reference = config.reference;
    reference.extent = std::min(config.closure.submap_extent, reference.extent);
    submap_.emplace(reference);
    divide();
  }

  /// Matches each keyframe with the other visits to its place, at the poses as they are.
  void tieAll(const std::function<void(double)>& progress) {
    ties.clear();
    checks.clear();
    std::vector<Visit> visits;
    for (int id = 0; id < keyframes.size(); ++id) {
      if (inMap(id)) addVisits(id, visits);
    }
    std::stable_sort(visits.begin(), visits.end(),
                     [](const Visit& a, const Visit& b) { return a.stretch < b.stretch; });
    int stretch = -1;
    compared = static_cast<int>(visits.size());
    for (std::size_t i = 0; i < visits.size(); ++i) {
      const Visit& visit = visits[i];
      if (std::exchange(stretch, visit.stretch) != visit.stretch) takeSubmap(stretches_[at(visit.stretch)]);
      if (const auto edge = tie(visit)) (visit.to % refine_.held_back == 0 ? checks : ties).push_back(*edge);
      if (progress) progress(static_cast<double>(i + 1) / static_cast<double>(visits.size()));
    }
  }

  /// Takes the ties into the graph in the place of those of the same visits, and the poses to its optimum, laid where
  /// the map was.
  void optimise() {
    KeyframeGraph tied;
    for (int id = 0; id < keyframes.size(); ++id) tied.add(keyframes.scan(id), keyframes.pose(id));
    PoseGraph& graph = tied.graph();
    std::set<std::pair<int, int>> anew;  // stretch and keyframe
    for (const Edge& edge : ties) anew.insert({stretch_of_[at(edge.from)], edge.to});
    for (const Edge& edge : keyframes.graph().edges()) {
      const bool known = edge.kind == EdgeKind::kLoopClosure && anew.contains({stretch_of_[at(edge.from)], edge.to});
      if (!known) graph.addEdge(edge);
    }
    std::vector<int> added;
    for (const Edge& edge : ties) added.push_back(graph.addEdge(edge));
    revoked = 0;
    Optimiser optimiser(config_.optimiser);
    for (int before = -1; before != revoked;) {
      before = revoked;
      optimiser.optimise(graph);
      for (const int id : added) {
        const Edge& edge = graph.edges()[at(id)];
        const bool stands =
            chiSquare(edge, graph.pose(edge.from), graph.pose(edge.to)) <= config_.closure.max_chi_square;
        if (edge.revoked || stands) continue;
        graph.revoke(id);
        ++revoked;
      }
    }
    std::vector<Pose2> T_map_node, T_new_node;
    for (int id = 0; id < graph.size(); ++id) {
      if (!inMap(id)) continue;
      T_map_node.push_back(keyframes.pose(id));
      T_new_node.push_back(graph.pose(id));
    }
    const Pose2 T_map_new = alignToPreviousMap(T_map_node, T_new_node);
    for (int id = 0; id < graph.size(); ++id) graph.setPose(id, T_map_new * graph.pose(id));
    keyframes = std::move(tied);
  }

  /// @pre tieAll() at these poses
  MapFigures figures() const { return {wallThickness(keyframes, in_map_, refine_.walls), gapOf(ties), gapOf(checks)}; }

  KeyframeGraph keyframes;
  std::vector<Edge> ties, checks;  // checks have no say in the poses
  int compared = 0, revoked = 0;

 private:
  bool inMap(int id) const { return in_map_[at(id)] != 0; }

  void divide() {
    double path = 0.0;
    for (int id = 0; id < keyframes.size(); ++id) {
      const double step =
          id == 0 ? 0.0 : (keyframes.pose(id).translation() - keyframes.pose(id - 1).translation()).norm();
      const bool begins = step > refine_.longest_step;
      path += begins ? refine_.apart + step : step;
      if (stretches_.empty() || begins || path - path_[at(stretches_.back().first)] > refine_.stretch)
        stretches_.push_back({id, id});
      stretches_.back().last = id;
      path_.push_back(path);
      stretch_of_.push_back(static_cast<int>(stretches_.size()) - 1);
    }
  }

  void addVisits(int id, std::vector<Visit>& visits) const {
    const Pose2& here = keyframes.pose(id);
    const auto first = std::ssize(visits);
    for (const int other : keyframes.near(here.translation(), refine_.distance)) {
      if (!inMap(other) || std::abs(path_[at(other)] - path_[at(id)]) < refine_.apart) continue;
      const Pose2& there = keyframes.pose(other);
      const double unlikeness =
          (there.translation() - here.translation()).norm() + 1.0 - std::cos(there.theta - here.theta);
      const Visit visit{stretch_of_[at(other)], other, id, unlikeness};
      const auto known = std::find_if(visits.begin() + first, visits.end(),
                                      [&](const Visit& one) { return one.stretch == visit.stretch; });
      if (known == visits.end()) {
        visits.push_back(visit);
      } else if (unlikeness < known->unlikeness) {
        *known = visit;
      }
    }
    std::stable_sort(visits.begin() + first, visits.end(),
                     [](const Visit& a, const Visit& b) { return a.unlikeness < b.unlikeness; });
    const auto most = static_cast<std::size_t>(first + refine_.most_visits);
    if (visits.size() > most) visits.resize(most);
  }

  void takeSubmap(const Stretch& stretch) {
    std::vector<int> ids;
    for (int id = stretch.first; id <= stretch.last; ++id) {
      if (inMap(id)) ids.push_back(id);
    }
    submap_->clear(keyframes.pose(ids[ids.size() / 2]).translation());
    keyframes.addTo(*submap_, ids);
  }

  /// @pre the submap is that of the visit @return none where the two do not match
  std::optional<Edge> tie(const Visit& visit) {
    keyframes.points(visit.to, points_);
    const Pose2& T_map_to = keyframes.pose(visit.to);
    const MatchResult found = matchPointToLine(*submap_, points_, T_map_to, match_);
    if (!found.usable() || found.overlap < match_.min_overlap) return std::nullopt;
    const Pose2 move = between(T_map_to, found.T_ref_base);
    if (move.translation().norm() > refine_.window || std::abs(move.theta) > refine_.window_turn) return std::nullopt;
    return Edge{.from = visit.from,
                .to = visit.to,
                .T_from_to = between(keyframes.pose(visit.from), found.T_ref_base),
                .information = closureInformation(found, refine_.translation_sigma, refine_.rotation_sigma),
                .kind = EdgeKind::kLoopClosure};
  }

  double gapOf(std::span<const Edge> edges) const {
    double squares = 0.0;
    for (const Edge& edge : edges)
      squares +=
          between(keyframes.pose(edge.from) * edge.T_from_to, keyframes.pose(edge.to)).translation().squaredNorm();
    return edges.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(edges.size()));
  }

  const std::vector<char>& in_map_;
  const BackEndConfig& config_;
  const RefineConfig& refine_;
  MatchConfig match_;
  std::optional<Reference> submap_;
  ScanPoints points_;
  std::vector<double> path_;  // [m] driven up to each keyframe
  std::vector<Stretch> stretches_;
  std::vector<int> stretch_of_;  // by keyframe
};

/// Whether all that was measured speaks for the new poses.
bool isBetter(const MapFigures& before, const MapFigures& after, double least_gain) {
  const auto falls = [&](double was, double is) { return is < (1.0 - least_gain) * was; };
  return falls(before.revisits, after.revisits) && falls(before.held_back, after.held_back) &&
         after.wall_thickness <= before.wall_thickness;
}

/// The map with other poses, drawn anew. The robot stays where it was relative to the keyframe nearest to it.
MapState laidOut(const MapState& map, KeyframeGraph keyframes, OccupancyGridConfig grid,
                 const std::function<void(double)>& progress) {
  int nearest = -1;
  double shortest = std::numeric_limits<double>::infinity();
  for (int id = 0; id < map.keyframes.size(); ++id) {
    const double apart = (map.keyframes.pose(id).translation() - map.T_map_base.translation()).norm();
    if (map.in_map[at(id)] == 0 || apart >= shortest) continue;
    shortest = apart;
    nearest = id;
  }
  MapState refined;
  refined.T_map_base = keyframes.pose(nearest) * between(map.keyframes.pose(nearest), map.T_map_base);
  refined.keyframes = std::move(keyframes);
  refined.in_map = map.in_map;
  refined.views = map.views;
  refined.edits = map.edits;  // tied to keyframes
  refined.gyro_bias = map.gyro_bias;
  refined.body = map.body;
  refined.T_base_lidar = map.T_base_lidar;
  refined.range_max = map.range_max;
  refined.utime = map.utime;
  grid.resolution = map.grid.resolution();
  ++refined.edits.revision;
  refined.grid = drawGrid(refined, grid, progress);
  refined.grid_keyframes = refined.keyframes.size();
  return refined;
}

}  // namespace

RefinedMap refineMap(const MapState& map, const BackEndConfig& config, const OccupancyGridConfig& grid,
                     const RefineConfig& refine, const std::function<void(double)>& progress) {
  RefinedMap result;
  RefineReport& report = result.report;
  const auto known = std::count_if(map.in_map.begin(), map.in_map.end(), [](char in_map) { return in_map != 0; });
  if (map.kind != MapKind::kScans || known < 2) {
    report.outcome = map.kind != MapKind::kScans ? Outcome::kFloorPlan : Outcome::kNoKeyframes;
    return result;
  }
  const auto part = [&progress](double begin, double end) -> std::function<void(double)> {
    if (!progress) return {};
    return [&progress, begin, end](double share) { progress(begin + (end - begin) * share); };
  };
  Refinement refinement(map, config, refine);
  for (int round = 0;; ++round) {
    const double each = refine.matching / (1.0 + refine.rounds);
    refinement.tieAll(part(each * round, each * (round + 1)));
    report.compared = refinement.compared;
    report.verified = static_cast<int>(refinement.ties.size() + refinement.checks.size());
    if (refinement.ties.empty() || refinement.checks.empty()) return result;
    if (round == 0) report.before = refinement.figures();
    if (round == refine.rounds) break;
    refinement.optimise();
  }
  report.after = refinement.figures();
  report.revoked = refinement.revoked;
  report.outcome = isBetter(report.before, report.after, refine.least_gain) ? Outcome::kRefined : Outcome::kNoBetter;
  if (report.outcome == Outcome::kRefined)
    result.map = laidOut(map, std::move(refinement.keyframes), grid, part(refine.matching, 1.0));
  return result;
}

}  // namespace slam
