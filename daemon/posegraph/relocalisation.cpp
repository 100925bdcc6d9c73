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
  for (const int id : map) in_map_[static_cast<std::size_t>(id)] = 1;
  field_.emplace(keyframes, map);
  global_.emplace(field_->wallPoints(), config_.search);
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
  keyframes.gather(newest, oldest, config_.query_length, config_.max_query_points, query_);
  sampleDirections();
  view_.gather(keyframes, oldest, newest, config_.query_length, config_.part_length);
  const std::vector<PlaceFit> places = candidates();
  if (places.empty() || places.front().seen < config_.min_seen) {
    ++counters_.refused;
    return std::nullopt;
  }
  const PlaceFit& best = places.front();
  const double lead = places.size() > 1 ? best.log_likelihood - places[1].log_likelihood : config_.sure_lead;
  const bool confirmed = confirm({best.T_map_newest * keyframes.pose(newest).inverse(), path_}, keyframes.pose(newest));
  if (lead < config_.min_lead) {
    ++counters_.ambiguous;
    return std::nullopt;
  }
  ++counters_.found;
  buildSubmap(keyframes, best.T_map_newest.translation());
  Found found{best.T_map_newest, matchPointToLine(submap_, query_, best.T_map_newest, match_)};
  found.confirmed = found.match.usable() && (confirmed || lead >= config_.sure_lead);
  counters_.confirmed += found.confirmed ? 1 : 0;
  return found;
}

/// The places that the segment may have in the map, most likely first, each once.
std::vector<PlaceFit> Relocalisation::candidates() const {
  std::vector<PlaceFit> fits, places;
  for (const GlobalPlace& place : global_->search(sample_, config_.min_score, config_.places, config_.place_share)) {
    fits.push_back(fitPlace(*field_, view_, place.T_map_query, config_.beams));
  }
  std::sort(fits.begin(), fits.end(), [](const auto& a, const auto& b) { return a.log_likelihood > b.log_likelihood; });
  for (const PlaceFit& fit : fits) {
    const bool known = std::any_of(places.begin(), places.end(),
                                   [&](const PlaceFit& other) { return same(other.T_map_newest, fit.T_map_newest); });
    if (!known) places.push_back(fit);
  }
  return places;
}

bool Relocalisation::same(const Pose2& a, const Pose2& b) const {
  const Pose2 gap = between(a, b);
  return std::hypot(gap.x, gap.y) < config_.same_distance && std::abs(gap.theta) < config_.same_rotation;
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
  std::size_t left = static_cast<std::size_t>(config_.max_search_points), groups = points.size();
  for (const auto& group : points) {
    const std::size_t count = std::min(group.size(), left / groups--);
    for (std::size_t i = 0; i < count; ++i) {
      sample_.push_back(query_[group[i * group.size() / count]].position);
    }
    left -= count;
  }
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

/// Whether the best place further back was the same.
bool Relocalisation::confirm(const Find& find, const Pose2& T_segment_base) {
  const bool agrees = std::any_of(finds_.begin(), finds_.end(), [&](const Find& other) {
    return find.path - other.path >= config_.confirm_path &&
           same(other.T_map_segment * T_segment_base, find.T_map_segment * T_segment_base);
  });
  finds_.push_back(find);
  return agrees;
}

}  // namespace slam
