// SPDX-License-Identifier: BSD-3-Clause
#include "posegraph/relocalisation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "matching/plicp.hpp"

namespace slam {
namespace {

constexpr double kSubmapExtent = 102.4;  // [m]
constexpr double kBeforeEnd = 1.0;       // [m]
constexpr double kRayStep = 0.1;         // [m]
constexpr double kEnters = 0.3;          // cosine: a ray that grazes a wall may lie on either side of it
constexpr int kDirections = 12;          // of walls

ReferenceConfig submapConfig(ReferenceConfig config) {
  config.extent = std::min(kSubmapExtent, config.extent);
  return config;
}

}  // namespace

Relocalisation::Relocalisation(const RelocalisationConfig& config, const ReferenceConfig& reference,
                               const MatchConfig& match)
    : config_(config), match_(match), submap_(submapConfig(reference)) {
  match_.min_overlap = config.min_overlap;
}

void Relocalisation::begin(const KeyframeGraph& keyframes, std::span<const int> map) {
  begin();
  in_map_.assign(static_cast<std::size_t>(keyframes.size()), 0);
  std::vector<Eigen::Vector2d> walls;
  ScanPoints points;
  for (const int id : map) {
    in_map_[static_cast<std::size_t>(id)] = 1;
    keyframes.points(id, points);
    for (const ScanPoint& point : points) walls.push_back(keyframes.pose(id) * point.position);
  }
  global_.emplace(walls, config_.search);
}

void Relocalisation::begin() {
  finds_.clear();
  path_ = 0.0;
  searched_at_ = -1e9;
  seen_ = -1;
}

std::optional<Relocalisation::Found> Relocalisation::search(const KeyframeGraph& keyframes, int oldest, int newest) {
  for (seen_ = std::max(seen_, oldest); seen_ < newest; ++seen_) {
    path_ += (keyframes.pose(seen_ + 1).translation() - keyframes.pose(seen_).translation()).norm();
  }
  if (!global_ || path_ - searched_at_ < config_.interval) return std::nullopt;
  searched_at_ = path_;
  ++counters_.searches;
  keyframes.gather(newest, oldest, config_.query_length, config_.max_query_points, query_, &seen_from_);
  sampleDirections();
  const auto places = candidates(keyframes);
  if (places.empty()) {
    ++counters_.refused;
    return std::nullopt;
  }
  const Candidate& best = places.front();
  const double runner_up = places.size() > 1 ? places[1].score / best.score : 0.0;
  if (runner_up > config_.ambiguity) {
    ++counters_.ambiguous;
    return std::nullopt;
  }
  ++counters_.found;
  const Find find{best.T_map_query * keyframes.pose(newest).inverse(), path_};
  const bool confirmed = confirm(find, keyframes.pose(newest), best.match.overlap, runner_up);
  counters_.confirmed += confirmed ? 1 : 0;
  return Found{best.T_map_query, best.match, confirmed};
}

std::vector<Relocalisation::Candidate> Relocalisation::candidates(const KeyframeGraph& keyframes) {
  std::vector<Candidate> candidates;
  for (const GlobalPlace& place : global_->search(sample_, config_.min_score, config_.places, config_.place_share)) {
    buildSubmap(keyframes, place.T_map_query.translation());
    Candidate candidate;
    candidate.match = matchPointToLine(submap_, query_, place.T_map_query, match_);
    if (!candidate.match.usable() || candidate.match.observable < 3) continue;
    candidate.T_map_query = candidate.match.T_ref_base;
    candidate.score = fineScore(candidate.T_map_query);
    const bool same = std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& other) {
      const Pose2 gap = between(other.T_map_query, candidate.T_map_query);
      return std::hypot(gap.x, gap.y) < config_.confirm_distance && std::abs(gap.theta) < config_.confirm_rotation;
    });
    if (!same) candidates.push_back(candidate);
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  return candidates;
}

/// Fills sample_: each direction of wall gives as many points, as far as it has them.
void Relocalisation::sampleDirections() {
  std::array<std::vector<std::size_t>, kDirections + 1> points;  // the last one: on no line
  for (std::size_t i = 0; i < query_.size(); ++i) {
    const ScanPoint& point = query_[i];
    if (point.position.norm() > config_.max_range) continue;
    const double angle = std::atan2(point.normal.y(), point.normal.x()) + std::numbers::pi;
    const auto direction = static_cast<std::size_t>(angle / (2.0 * std::numbers::pi) * kDirections);
    points[point.hasNormal() ? std::min<std::size_t>(direction, kDirections - 1) : kDirections].push_back(i);
  }
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  sample_.clear();
  sample_seen_from_.clear();
  std::size_t left = static_cast<std::size_t>(config_.max_search_points), groups = points.size();
  for (const auto& group : points) {
    const std::size_t count = std::min(group.size(), left / groups--);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t point = group[i * group.size() / count];
      sample_.push_back(query_[point].position);
      sample_seen_from_.push_back(seen_from_[point]);
    }
    left -= count;
  }
}

double Relocalisation::fineScore(const Pose2& T_map_query) const {
  const double kernel_squared = config_.fine_kernel * config_.fine_kernel;
  double sum = 0.0;
  for (std::size_t i = 0; i < sample_.size(); ++i) {
    const Eigen::Vector2d p = T_map_query * sample_[i];
    const Surfel* surfel = submap_.nearest(p, config_.fine_kernel);
    if (surfel != nullptr) {
      sum += std::max(0.0, 1.0 - (p - Eigen::Vector2d(surfel->x, surfel->y)).squaredNorm() / kernel_squared);
    }
    if (seenThroughWall(T_map_query * sample_seen_from_[i], p)) sum -= 1.0;
  }
  return std::max(0.0, sum / static_cast<double>(sample_.size()));
}

/// Whether the line of sight enters a wall of the map well before its end.
bool Relocalisation::seenThroughWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  const double length = (to - from).norm() - kBeforeEnd;
  const Eigen::Vector2d direction = (to - from).normalized();
  for (double s = kRayStep; s < length; s += kRayStep) {
    const Eigen::Vector2d p = from + s * direction;
    const Surfel* surfel = submap_.nearest(p, kRayStep);
    if (surfel == nullptr || !surfel->isLine()) continue;
    const bool at = (p - Eigen::Vector2d(surfel->x, surfel->y)).squaredNorm() < kRayStep * kRayStep;
    if (at && direction.x() * surfel->nx + direction.y() * surfel->ny < -kEnters) return true;
  }
  return false;
}

std::optional<Relocalisation::Found> Relocalisation::searchNear(const KeyframeGraph& keyframes, int oldest, int newest,
                                                                const SearchWindow& window) {
  keyframes.gather(newest, oldest, config_.query_length, config_.max_query_points, query_);
  buildSubmap(keyframes, keyframes.pose(newest).translation());
  const SearchResult found = matcher_.match(submap_, query_, keyframes.pose(newest), window, match_);
  if (!found.match.usable() || found.match.overlap < config_.min_overlap) return std::nullopt;
  return Found{found.match.T_ref_base, found.match, true};
}

void Relocalisation::buildSubmap(const KeyframeGraph& keyframes, const Eigen::Vector2d& centre) {
  std::vector<int> members = keyframes.near(centre, config_.submap_radius);
  std::erase_if(members, [&](int id) {
    return id >= static_cast<int>(in_map_.size()) || in_map_[static_cast<std::size_t>(id)] == 0;
  });
  submap_.clear(centre);
  keyframes.addTo(submap_, members);
}

bool Relocalisation::confirm(const Find& find, const Pose2& T_segment_base, double overlap, double runner_up) {
  if (overlap >= config_.sure_overlap && runner_up <= config_.sure_runner_up) return true;
  const bool agrees = std::any_of(finds_.begin(), finds_.end(), [&](const Find& other) {
    const Pose2 gap = between(other.T_map_segment * T_segment_base, find.T_map_segment * T_segment_base);
    return find.path - other.path >= config_.confirm_path && std::hypot(gap.x, gap.y) < config_.confirm_distance &&
           std::abs(gap.theta) < config_.confirm_rotation;
  });
  finds_.push_back(find);
  return agrees;
}

}  // namespace slam
