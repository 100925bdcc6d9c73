// SPDX-License-Identifier: BSD-3-Clause
#include "posegraph/relocalisation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

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
  field_.emplace(keyframes, map, config_.beams);
  global_.emplace(field_->walls().wallPoints(), config_.search);
}

void Relocalisation::begin() {
  looks_.clear();
  T_map_segments_.clear();
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
  Look look{{}, keyframes.pose(newest)};
  look.view.gather(keyframes, oldest, newest, config_.query_length, config_.part_length);
  looks_.push_front(std::move(look));
  if (static_cast<int>(looks_.size()) > config_.searches) looks_.pop_back();
  const std::vector<PlaceFit> places = candidates();
  if (places.empty() || places.front().seen < config_.min_seen) {
    ++counters_.refused;
    return std::nullopt;
  }
  const std::optional<Pose2> best = leader(places);
  if (!best) {
    ++counters_.ambiguous;
    return std::nullopt;
  }
  buildSubmap(keyframes, best->translation());
  const MatchResult match = matchPointToLine(submap_, query_, *best, match_);
  if (!match.usable() || !same(match.T_ref_base, *best)) {
    ++counters_.refused;
    return std::nullopt;
  }
  ++counters_.found;
  return Found{match.T_ref_base, match};
}

/// The place that leads all others, by the newest search or in the mean of the last ones. Each place is judged by what
/// all of them saw, whether they found it themselves or not, and lies in the middle of where they put it.
std::optional<Pose2> Relocalisation::leader(std::span<const PlaceFit> places) const {
  struct Contender {
    double sum = 0.0;  // of log-likelihoods
    /// [m, m, rad] sum over the searches, from where the newest one put it
    Eigen::Vector3d moved = Eigen::Vector3d::Zero();
  };
  places = places.first(std::min(places.size(), static_cast<std::size_t>(config_.contenders)));
  std::vector<Contender> contenders(places.size());
  for (std::size_t searches = 1; searches <= looks_.size(); ++searches) {
    const Look& look = looks_[searches - 1];
    const Pose2 T_newest_look = between(looks_.front().T_segment_newest, look.T_segment_newest);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Pose2& T_map_newest = places[i].T_map_newest;
      const PlaceFit fit = searches == 1 ? places[i] : fitPlace(*field_, look.view, T_map_newest * T_newest_look);
      const Pose2 moved = between(T_map_newest, fit.T_map_newest * T_newest_look.inverse());
      contenders[i].sum += fit.log_likelihood;
      contenders[i].moved += Eigen::Vector3d(moved.x, moved.y, moved.theta);
    }
    const auto less = [](const Contender& a, const Contender& b) { return a.sum < b.sum; };
    const auto best = std::max_element(contenders.begin(), contenders.end(), less);
    double second = -std::numeric_limits<double>::infinity();
    for (auto other = contenders.begin(); other != contenders.end(); ++other) {
      if (other != best) second = std::max(second, other->sum);
    }
    const auto n = static_cast<double>(searches);
    if ((best->sum - second) / n < config_.min_lead * (1.0 + 1.0 / n)) continue;
    const Eigen::Vector3d moved = best->moved / n;
    return places[static_cast<std::size_t>(best - contenders.begin())].T_map_newest *
           Pose2{moved.x(), moved.y(), moved.z()};
  }
  return std::nullopt;
}

/// The places that the segment may have in the map, most likely first, each once: what the search finds, and what it
/// found best the last time.
std::vector<PlaceFit> Relocalisation::candidates() {
  const Look& look = looks_.front();
  std::vector<PlaceFit> fits, places;
  for (const GlobalPlace& place : global_->search(sample_, config_.min_score, config_.places, config_.place_share)) {
    fits.push_back(fitPlace(*field_, look.view, place.T_map_query));
  }
  for (const Pose2& T_map_segment : T_map_segments_) {
    fits.push_back(fitPlace(*field_, look.view, T_map_segment * look.T_segment_newest));
  }
  std::sort(fits.begin(), fits.end(), [](const auto& a, const auto& b) { return a.log_likelihood > b.log_likelihood; });
  for (const PlaceFit& fit : fits) {
    const bool known = std::any_of(places.begin(), places.end(),
                                   [&](const PlaceFit& other) { return same(other.T_map_newest, fit.T_map_newest); });
    if (!known) places.push_back(fit);
  }
  T_map_segments_.clear();
  for (const PlaceFit& place : places) {
    if (static_cast<int>(T_map_segments_.size()) == config_.contenders) break;
    T_map_segments_.push_back(place.T_map_newest * look.T_segment_newest.inverse());
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
  return Found{found.match.T_ref_base, found.match};
}

void Relocalisation::buildSubmap(const KeyframeGraph& keyframes, const Eigen::Vector2d& centre) {
  std::vector<int> members = keyframes.near(centre, config_.submap_radius);
  std::erase_if(members, [&](int id) {
    return id >= static_cast<int>(in_map_.size()) || in_map_[static_cast<std::size_t>(id)] == 0;
  });
  submap_.clear(centre);
  keyframes.addTo(submap_, members);
}

}  // namespace slam
