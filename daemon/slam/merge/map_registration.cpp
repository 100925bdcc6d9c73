// SPDX-License-Identifier: BSD-3-Clause
#include "slam/merge/map_registration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slam {

MapRegistration::MapRegistration(const KeyframeGraph& keyframes, std::span<const int> map, std::span<const int> second,
                                 const MapRegistrationConfig& config)
    : keyframes_(keyframes), config_(config), places_(config.places) {
  places_.begin(keyframes, map);
  divide(second);
}

/// Fills stretches_.
void MapRegistration::divide(std::span<const int> second) {
  std::vector<Stretch> all;
  double path = 0.0;
  for (std::size_t i = 0; i < second.size(); ++i) {
    const int id = second[i];
    const double step =
        i == 0 ? 0.0 : (keyframes_.pose(id).translation() - keyframes_.pose(second[i - 1]).translation()).norm();
    const bool goes_on = i > 0 && id == second[i - 1] + 1 && step < config_.longest_step;
    if (!goes_on || path >= config_.stretch) {
      all.push_back({goes_on ? all.back().run : id, id, id});
      path = 0.0;
    } else {
      path += step;
    }
    all.back().newest = id;
  }
  const std::size_t count = std::min(all.size(), static_cast<std::size_t>(config_.most_stretches));
  for (std::size_t i = 0; i < count; ++i) stretches_.push_back(all[i * all.size() / count]);
}

PlaceAgreement MapRegistration::agreement(const Stretch& stretch, const Pose2& T_map_newest) const {
  QueryCloud view;
  const DecayRateMap& field = places_.field();
  const double whole = std::numeric_limits<double>::max();
  view.gather(keyframes_, stretch.oldest, stretch.newest, whole, whole, 0.0);
  const PlaceFit fit = fitPlace(field, view, T_map_newest, config_.places.fit);
  PlaceAgreement result{.T_map_newest = fit.T_map_newest};
  const BeamModel& model = field.model();
  result.log_likelihood = fit.log_likelihood - view.weight(model) * view.rays * field.logRateUnknown();
  const double free_below = 0.5 * (field.logRateUnknown() + std::log(model.rate_free));
  const PointTransform T(fit.T_map_newest);
  std::vector<DecayRateMap::Passed> passed;
  for (const QueryCloud::Part& part : view.parts) {
    for (const QueryCloud::Ray& ray : part.rays) {
      const double log_rate = field.logRate(T * ray.to, ray.range);
      passed.clear();
      const bool through =
          field.pass(T * ray.from, T * ray.to, passed) < config_.places.fit.through * model.logThrough();
      ++(through || log_rate < free_below ? result.contradicted
         : field.atWall(log_rate)         ? result.walls
                                          : result.unknown);
    }
  }
  return result;
}

/// Log-likelihood over that of unmapped space of what lies in known space, where it was mapped: see PlaceSearch.
double MapRegistration::expected(const PlaceAgreement& all) const {
  const DecayRateMap& field = places_.field();
  const double weight = QueryCloud{}.weight(field.model());
  return weight * all.known() * config_.places.model.unchanged * (field.logRateWalls() - field.logRateUnknown());
}

/// @param way [m] between what either place is known by
bool MapRegistration::near(const Pose2& T_map_a, const Pose2& T_map_b, double way) const {
  const Pose2 gap = between(T_map_a, T_map_b);
  return std::hypot(gap.x, gap.y) < config_.same_distance + config_.bend * way &&
         std::abs(gap.theta) < config_.same_rotation;
}

/// Whether two hypotheses lay the stretches, fitted to the map, at the same places.
bool MapRegistration::same(const Hypothesis& a, const Hypothesis& b) const {
  int same = 0, known = 0;
  for (std::size_t i = 0; i < a.at.size(); ++i) {
    if (a.at[i].log_likelihood <= 0.0) continue;
    ++known;
    same += near(a.at[i].T_map_newest, b.at[i].T_map_newest, 0.0) ? 1 : 0;
  }
  return 2 * same > known;
}

MapRegistration::Hypothesis MapRegistration::evaluated(const Pose2& T_map_second) const {
  Hypothesis hypothesis{T_map_second};
  for (const Stretch& stretch : stretches_) {
    const PlaceAgreement at = agreement(stretch, T_map_second * keyframes_.pose(stretch.newest));
    hypothesis.all.log_likelihood += at.log_likelihood;
    hypothesis.all.walls += at.walls;
    hypothesis.all.contradicted += at.contradicted;
    hypothesis.all.unknown += at.unknown;
    hypothesis.at.push_back(at);
  }
  return hypothesis;
}

/// Fills found_. @return where the searches put the second map, the best place of each search first
std::vector<Pose2> MapRegistration::search(const std::function<void(double)>& progress) {
  std::vector<std::vector<Pose2>> candidates;
  for (const Stretch& stretch : stretches_) {
    places_.begin();
    const auto result = places_.search(keyframes_, stretch.run, stretch.newest);
    candidates.emplace_back(places_.contenders().begin(), places_.contenders().end());
    if (result.outcome == PlaceSearch::Outcome::kFound) {
      found_.push_back({stretch.newest, result.T_map_newest});
      candidates.back().insert(candidates.back().begin(),
                               result.T_map_newest * keyframes_.pose(stretch.newest).inverse());
    }
    if (progress) progress(static_cast<double>(candidates.size()) / static_cast<double>(stretches_.size()));
  }
  std::vector<Pose2> in_order;
  for (const RegisteredMap::Found& found : found_)
    in_order.push_back(found.T_map_keyframe * keyframes_.pose(found.keyframe).inverse());
  const auto places = static_cast<std::size_t>(config_.places.contenders);
  for (std::size_t rank = 0; rank <= places; ++rank) {
    for (const auto& of_stretch : candidates) {
      if (rank < of_stretch.size()) in_order.push_back(of_stretch[rank]);
    }
  }
  return in_order;
}

/// The hypotheses, likeliest first, each once.
std::vector<MapRegistration::Hypothesis> MapRegistration::compare(std::span<const Pose2> candidates,
                                                                  const std::function<void(double)>& progress) const {
  std::vector<Hypothesis> hypotheses;
  std::vector<Pose2> tried;
  for (const Pose2& T_map_second : candidates) {
    if (static_cast<int>(tried.size()) == config_.most_hypotheses) break;
    const Pose2 middle = keyframes_.pose(stretches_[stretches_.size() / 2].newest);
    const bool known = std::any_of(tried.begin(), tried.end(), [&](const Pose2& T_map_other) {
      return near(T_map_second * middle, T_map_other * middle, 0.0);
    });
    if (known) continue;
    tried.push_back(T_map_second);
    hypotheses.push_back(evaluated(T_map_second));
    if (progress) progress(static_cast<double>(tried.size()) / config_.most_hypotheses);
  }
  std::erase_if(hypotheses, [&](const Hypothesis& hypothesis) {
    return hypothesis.all.share() < config_.min_agreement ||
           hypothesis.all.log_likelihood < config_.min_likelihood * expected(hypothesis.all);
  });
  std::stable_sort(hypotheses.begin(), hypotheses.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.all.log_likelihood > b.all.log_likelihood;
  });
  std::vector<Hypothesis> others;
  for (Hypothesis& hypothesis : hypotheses) {
    const bool known =
        std::any_of(others.begin(), others.end(), [&](const Hypothesis& other) { return same(other, hypothesis); });
    if (!known) others.push_back(std::move(hypothesis));
  }
  return others;
}

/// Which of the stretches that were found by themselves lie where a hypothesis puts them.
void MapRegistration::count(const Hypothesis& best, RegisteredMap& result) const {
  for (const RegisteredMap::Found& found : found_) {
    const auto at = std::find_if(stretches_.begin(), stretches_.end(),
                                 [&](const Stretch& stretch) { return stretch.newest == found.keyframe; });
    const auto& fitted = best.at[static_cast<std::size_t>(at - stretches_.begin())];
    if (near(fitted.T_map_newest, found.T_map_keyframe, 0.0)) {
      result.found.push_back(found);
    } else {
      ++result.elsewhere;
      result.T_map_other = found.T_map_keyframe * keyframes_.pose(found.keyframe).inverse();
    }
  }
}

RegisteredMap MapRegistration::find(const std::function<void(double)>& progress) {
  RegisteredMap result{.stretches = static_cast<int>(stretches_.size())};
  if (stretches_.empty()) return result;
  const auto part = [&](double begin) -> std::function<void(double)> {
    if (!progress) return {};
    return [&progress, begin](double share) { progress(begin + 0.5 * share); };
  };
  const std::vector<Pose2> candidates = search(part(0.0));
  const std::vector<Hypothesis> hypotheses = compare(candidates, part(0.5));
  result.elsewhere = static_cast<int>(found_.size());
  if (hypotheses.empty()) return result;
  const Hypothesis& best = hypotheses.front();
  result.elsewhere = 0;
  result.T_map_second = best.T_map_second;
  result.agreement = best.all.share();
  result.overlap = best.all.overlap();
  result.margin = best.all.log_likelihood;
  result.needed = std::max(config_.min_margin, config_.min_margin_share * best.all.log_likelihood);
  count(best, result);
  if (hypotheses.size() > 1) {
    result.margin -= hypotheses[1].all.log_likelihood;
    if (result.margin < result.needed) {
      if (result.overlap >= config_.min_overlap) result.outcome = RegisteredMap::Outcome::kAmbiguous;
      result.T_map_other = hypotheses[1].T_map_second;
      return result;
    }
  }
  const auto found = static_cast<double>(result.found.size());
  if (result.elsewhere > config_.max_elsewhere * (found + result.elsewhere)) {
    if (found > 0) result.outcome = RegisteredMap::Outcome::kContradictory;
    return result;
  }
  const double known = result.overlap * result.stretches;
  if (found >= std::max<double>(config_.min_found, config_.min_found_share * known))
    result.outcome = RegisteredMap::Outcome::kFound;
  return result;
}

}  // namespace slam
