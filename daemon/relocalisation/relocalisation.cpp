// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/relocalisation.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "matching/plicp.hpp"

namespace slam {
namespace {

ReferenceConfig submapConfig(ReferenceConfig config, double extent) {
  config.extent = std::min(extent, config.extent);
  return config;
}

}  // namespace

Relocalisation::Relocalisation(const RelocalisationConfig& config, const ReferenceConfig& reference,
                               const MatchConfig& match)
    : config_(config),
      match_(match),
      places_(config.places),
      submap_config_(submapConfig(reference, config.submap_extent)),
      work_(config.work_saved) {
  match_.min_overlap = config.min_overlap;
  match_.max_iterations = std::max(match_.max_iterations, config.max_iterations);
}

void Relocalisation::begin(const KeyframeGraph& keyframes, std::span<const int> map) {
  atlas_.reset();
  beginIn(keyframes, map);
}

void Relocalisation::begin(std::shared_ptr<const FloorAtlas> atlas) {
  atlas_ = std::move(atlas);
  std::vector<int> all(static_cast<std::size_t>(atlas_->keyframes().size()));
  std::iota(all.begin(), all.end(), 0);
  beginIn(atlas_->keyframes(), all);
}

void Relocalisation::beginIn(const KeyframeGraph& keyframes, std::span<const int> map) {
  begin();
  in_map_.assign(static_cast<std::size_t>(keyframes.size()), 0);
  for (const int id : map) in_map_[static_cast<std::size_t>(id)] = 1;
  places_.begin(keyframes, map);
}

void Relocalisation::begin() {
  places_.begin();
  path_ = 0.0;
  searched_at_ = -1e9;
  seen_ = -1;
}

std::optional<Relocalisation::Found> Relocalisation::search(const KeyframeGraph& keyframes, int oldest, int newest,
                                                            double heading_tolerance) {
  for (seen_ = std::max(seen_, oldest); seen_ < newest; ++seen_) {
    path_ += (keyframes.pose(seen_ + 1).translation() - keyframes.pose(seen_).translation()).norm();
  }
  if (!places_.hasMap() || work_ <= 0) return std::nullopt;
  if (!places_.underWay()) {
    if (path_ - searched_at_ < config_.interval) return std::nullopt;
    searched_at_ = path_;
  }
  const std::int64_t allowed = std::min(work_, config_.work_at_once);
  std::int64_t left = allowed;
  const PlaceSearch::Result place = places_.search(keyframes, oldest, newest, {}, heading_tolerance, &left);
  work_ -= allowed - left;
  if (place.outcome == PlaceSearch::Outcome::kUnfinished) {
    ++counters_.interrupted;
    return std::nullopt;
  }
  ++counters_.searches;
  newest_ = place;
  if (place.outcome != PlaceSearch::Outcome::kFound) {
    ++(place.outcome == PlaceSearch::Outcome::kAmbiguous ? counters_.ambiguous : counters_.refused);
    return std::nullopt;
  }
  gather(keyframes, oldest, newest);
  buildSubmap(keyframes, place.T_map_newest.translation());
  const MatchResult match = matchPointToLine(*submap_, query_, place.T_map_newest, match_);
  if (!match.usable() || !places_.same(match.T_ref_base, place.T_map_newest)) {
    ++counters_.refused;
    return std::nullopt;
  }
  ++counters_.found;
  return Found{match.T_ref_base, match};
}

void Relocalisation::gather(const KeyframeGraph& keyframes, int oldest, int newest) {
  keyframes.gather(newest, oldest, config_.places.query_length, config_.places.max_query_points, query_);
}

std::optional<Relocalisation::Found> Relocalisation::searchNear(const KeyframeGraph& keyframes, int oldest, int newest,
                                                                const SearchWindow& window) {
  gather(keyframes, oldest, newest);
  buildSubmap(keyframes, keyframes.pose(newest).translation());
  const SearchResult found = matcher_.match(*submap_, query_, keyframes.pose(newest), window, match_);
  if (!found.match.usable() || found.match.overlap < config_.min_overlap) return std::nullopt;
  return Found{found.match.T_ref_base, found.match};
}

void Relocalisation::buildSubmap(const KeyframeGraph& keyframes, const Eigen::Vector2d& centre) {
  const KeyframeGraph& map = atlas_ ? atlas_->keyframes() : keyframes;
  std::vector<int> members = map.near(centre, config_.submap_radius);
  std::erase_if(members, [&](int id) {
    return id >= static_cast<int>(in_map_.size()) || in_map_[static_cast<std::size_t>(id)] == 0;
  });
  if (!submap_) submap_.emplace(submap_config_);
  submap_->clear(centre);
  map.addTo(*submap_, members);
}

}  // namespace slam
