// SPDX-License-Identifier: BSD-3-Clause
#include "posegraph/relocalisation.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr double kSubmapExtent = 102.4;        // [m]
constexpr SearchWindow kRefinement{0.3, 0.1};  // about the place that the search's grid names

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
  keyframes.gather(newest, oldest, config_.query_length, config_.max_query_points, query_);
  const auto place = global_->search(query_, config_.min_score);
  if (!place) return std::nullopt;
  if (place->runner_up > config_.ambiguity) {
    ++counters_.ambiguous;
    return std::nullopt;
  }
  buildSubmap(keyframes, place->T_map_query.translation());
  const SearchResult found = matcher_.match(submap_, query_, place->T_map_query, kRefinement, match_);
  if (!found.match.usable() || found.match.observable < 3 || found.match.overlap < config_.min_overlap) {
    ++counters_.refused;
    return std::nullopt;
  }
  ++counters_.found;
  const Pose2 T_map_segment = found.match.T_ref_base * keyframes.pose(newest).inverse();
  const bool confirmed = confirm({T_map_segment, path_}, keyframes.pose(newest), found.match.overlap, place->runner_up);
  counters_.confirmed += confirmed ? 1 : 0;
  return Found{found.match.T_ref_base, found.match, confirmed};
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
