// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/loop_closure.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "matching/normals.hpp"

namespace slam {
namespace {

double distance(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// [m] Half a lidar sees the same only in the same direction.
double unlikeness(const Pose2& a, const Pose2& b) { return distance(a, b) + 1.0 - std::cos(a.theta - b.theta); }

CorrelativeConfig offlineSearch() {
  CorrelativeConfig config;
  config.max_hypotheses = 1 << 17;  // not in the pose path: it may take its time
  return config;
}

}  // namespace

Eigen::Matrix3d closureInformation(const MatchResult& match, double translation_sigma, double rotation_sigma) {
  const double c = std::cos(match.T_ref_base.theta), s = std::sin(match.T_ref_base.theta);
  Eigen::Matrix3d turn;
  turn << c, s, 0, -s, c, 0, 0, 0, 1;
  const auto seen = match.directions.leftCols(match.observable);
  Eigen::Matrix3d covariance = match.covariance;
  covariance.diagonal() += Eigen::Vector3d(translation_sigma, translation_sigma, rotation_sigma).cwiseAbs2();
  const Eigen::MatrixXd information = (seen.transpose() * covariance * seen).inverse();
  return turn * (seen * information * seen.transpose()) * turn.transpose();
}

LoopClosureSearch::LoopClosureSearch(const LoopClosureConfig& config, const PlaceSearchConfig& places,
                                     const ReferenceConfig& reference, const MatchConfig& match)
    : config_(config), places_config_(places), match_(match), submap_config_(reference), matcher_(offlineSearch()) {
  submap_config_.extent = std::min(config.submap_extent, reference.extent);
  match_.min_overlap = config.min_overlap;
  places_config_.model.beams.unknown_as_wall = config.unknown_as_wall;
}

std::vector<Edge> LoopClosureSearch::search(const KeyframeGraph& keyframes, std::span<const char> in_map) {
  const int newest = keyframes.size() - 1;
  for (; seen_ < newest; ++seen_) path_ += distance(keyframes.pose(seen_), keyframes.pose(seen_ + 1));
  if (path_ - searched_at_ < config_.search_interval) return {};
  auto place = candidate(keyframes, newest, in_map);
  if (!place) return {};
  searched_at_ = path_;
  ++counters_.searches;
  const bool wide = place->window.translation > config_.sure_window;
  if (wide) place = narrow(keyframes, newest, *place, in_map);
  if (!place) return {};
  const auto edge = verify(keyframes, newest, *place);
  if (!edge) return {};
  ++counters_.found;

  std::erase_if(pending_, [&](const Pending& p) { return path_ - p.path > config_.pending_distance; });
  std::vector<Edge> accepted;
  if (wide || last_overlap_ < config_.sure_overlap) {
    double apart = 0.0;
    for (const Pending& other : pending_) {
      if (!agree(keyframes, other.edge, *edge)) continue;
      apart = std::max(apart, path_ - other.path);
      accepted.push_back(other.edge);
    }
    counters_.inconsistent += accepted.empty() && !pending_.empty() ? 1 : 0;
    if (accepted.empty() || (wide && apart < config_.agreement_distance)) {  // the same scans prove nothing twice
      pending_.push_back({*edge, path_});
      return {};
    }
  }
  accepted.push_back(*edge);
  pending_.clear();
  places_.search.reset();
  counters_.accepted += static_cast<int>(accepted.size());
  return accepted;
}

std::optional<LoopClosureSearch::Candidate> LoopClosureSearch::candidate(const KeyframeGraph& keyframes, int newest,
                                                                         std::span<const char> in_map) {
  const Pose2& here = keyframes.pose(newest);
  const double far = config_.max_search;
  auto near = keyframes.near(here.translation(), far);
  std::erase_if(near, [&](int id) { return in_map[static_cast<std::size_t>(id)] == 0; });
  const double active = config_.active_sigma * config_.active_sigma;
  known_.clear();
  for (const auto& reached : keyframes.graph().reach(newest, active)) known_.insert(reached.node);
  std::erase_if(near, [&](int id) { return known_.contains(id); });
  if (near.empty()) return std::nullopt;

  // How far off may each be? What was never reached within the bound is as far as the bound.
  struct Variance {
    double position, heading;  // [m^2, rad^2]
  };
  std::vector<Variance> variances(near.size(), {far * far, config_.max_turn * config_.max_turn});
  for (const auto& reached : keyframes.graph().reach(newest, far * far, near)) {
    const auto at = std::lower_bound(near.begin(), near.end(), reached.node);
    if (at == near.end() || *at != reached.node) continue;
    variances[static_cast<std::size_t>(at - near.begin())] = {reached.position_variance, reached.heading_variance};
  }
  std::optional<Candidate> best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < near.size(); ++i) {
    const int id = near[i];
    const auto [position, heading] = variances[i];
    const double window = std::clamp(config_.window_sigmas * std::sqrt(position), config_.min_search, far);
    // More than the drift and a look around the corner?
    if (distance(here, keyframes.pose(id)) > window + 2.0) continue;
    const double cost = unlikeness(here, keyframes.pose(id));
    if (cost >= best_cost) continue;
    best_cost = cost;
    best = Candidate{
        id, here, {window, std::clamp(config_.window_sigmas * std::sqrt(heading), config_.min_turn, config_.max_turn)}};
  }
  return best;
}

/// Finds the newest path's place in a wide window: there a corridor's doors and ends fit one another's places well
/// enough for any match.
std::optional<LoopClosureSearch::Candidate> LoopClosureSearch::narrow(const KeyframeGraph& keyframes, int newest,
                                                                      const Candidate& wide,
                                                                      std::span<const char> in_map) {
  // What is known this well fits into a narrow window.
  const double piece = std::pow(config_.sure_window / config_.window_sigmas, 2);
  known_.clear();
  for (const auto& reached : keyframes.graph().reach(newest, piece)) known_.insert(reached.node);
  const Eigen::Vector2d centre = keyframes.pose(wide.id).translation();
  if (path_ - places_.searched_at > config_.pending_distance) places_.search.reset();
  places_.searched_at = path_;
  if (!places_.search || (centre - places_.centre).norm() > 0.5 * config_.map_radius) {
    places_.keyframes.clear();
    for (const auto& reached : keyframes.graph().reach(wide.id, piece)) {
      const auto id = static_cast<std::size_t>(reached.node);
      const bool near = (keyframes.pose(reached.node).translation() - centre).norm() < config_.map_radius;
      if (near && in_map[id] != 0 && !known_.contains(reached.node)) places_.keyframes.push_back(reached.node);
    }
    std::sort(places_.keyframes.begin(), places_.keyframes.end());
    places_.search.emplace(places_config_).begin(keyframes, places_.keyframes);
    places_.centre = centre;
  }
  int oldest = newest;
  while (oldest > 0 && known_.contains(oldest - 1)) --oldest;
  std::int64_t work = config_.work_at_once;
  const PlaceWindow window{wide.T_map_newest, wide.window.translation, wide.window.rotation};
  const auto found = places_.search->search(keyframes, oldest, newest, window, std::numbers::pi, &work);
  counters_.ambiguous += found.outcome == PlaceSearch::Outcome::kAmbiguous ? 1 : 0;
  if (found.outcome != PlaceSearch::Outcome::kFound) return std::nullopt;
  const auto likest = std::min_element(places_.keyframes.begin(), places_.keyframes.end(), [&](int a, int b) {
    return unlikeness(keyframes.pose(a), found.T_map_newest) < unlikeness(keyframes.pose(b), found.T_map_newest);
  });
  return Candidate{*likest, found.T_map_newest, {config_.min_search, config_.min_turn}};
}

std::optional<Edge> LoopClosureSearch::verify(const KeyframeGraph& keyframes, int newest, const Candidate& place) {
  // The submap: keyframes around the candidate that are one map with it, but not with the robot.
  const double active = config_.active_sigma * config_.active_sigma;
  std::vector<int> members;
  for (const auto& reached : keyframes.graph().reach(place.id, active)) {
    if (distance(keyframes.pose(reached.node), keyframes.pose(place.id)) < config_.submap_radius) {
      members.push_back(reached.node);
    }
  }
  known_.clear();
  for (const auto& reached : keyframes.graph().reach(newest, active)) known_.insert(reached.node);
  std::erase_if(members, [&](int id) { return known_.contains(id); });
  const auto nearer = [&](int a, int b) {
    return distance(keyframes.pose(a), keyframes.pose(place.id)) <
           distance(keyframes.pose(b), keyframes.pose(place.id));
  };
  std::sort(members.begin(), members.end(), nearer);
  if (static_cast<int>(members.size()) > config_.max_submap)
    members.resize(static_cast<std::size_t>(config_.max_submap));
  std::sort(members.begin(), members.end());
  draw(keyframes, members, keyframes.pose(place.id).translation());
  // One scan only as far as it is one piece; beyond, keyframes of the submap would match themselves.
  int oldest = newest;
  while (oldest > 0 && known_.contains(oldest - 1)) --oldest;
  keyframes.points(newest, query_);
  const Eigen::Vector2d lidar = keyframes.scan(newest)->T_base_lidar.translation();
  MatchConfig match = match_;  // as tracking has it
  match.point_weight /= relativeSpacing(query_, lidar);
  keyframes.gather(newest, oldest, config_.query_length, config_.max_query_points, query_);

  const SearchResult found = matcher_.match(*submap_.reference, query_, place.T_map_newest, place.window, match);
  if (found.match.status == MatchStatus::kAmbiguous) ++counters_.ambiguous;
  if (!found.match.usable() || found.match.overlap < config_.min_overlap) return std::nullopt;
  last_overlap_ = found.match.overlap;

  return Edge{.from = place.id,
              .to = newest,
              .T_from_to = between(keyframes.pose(place.id), found.match.T_ref_base),
              .information = closureInformation(found.match, config_.translation_sigma, config_.rotation_sigma),
              .kind = EdgeKind::kLoopClosure};
}

void LoopClosureSearch::draw(const KeyframeGraph& keyframes, std::span<const int> ids, const Eigen::Vector2d& centre) {
  std::vector<Submap::Member> members;
  members.reserve(ids.size());
  for (const int id : ids) members.push_back({keyframes.pose(id), keyframes.scan(id)});
  if (submap_.reference && submap_.centre == centre && submap_.members == members) return;
  if (!submap_.reference) submap_.reference.emplace(submap_config_);
  submap_.reference->clear(centre);
  keyframes.addTo(*submap_.reference, ids);
  submap_.members = std::move(members);
  submap_.centre = centre;
}

bool LoopClosureSearch::agree(const KeyframeGraph& keyframes, const Edge& a, const Edge& b) const {
  // Around the loop a.from -> a.to -> b.to -> b.from -> a.from; the second and last leg are known from the graph.
  const Pose2 there = a.T_from_to * between(keyframes.pose(a.to), keyframes.pose(b.to));
  const Pose2 back = between(keyframes.pose(a.from), keyframes.pose(b.from)) * b.T_from_to;
  const Pose2 gap = between(there, back);
  return std::hypot(gap.x, gap.y) < config_.consistency && std::abs(gap.theta) < config_.consistency;
}

}  // namespace slam
