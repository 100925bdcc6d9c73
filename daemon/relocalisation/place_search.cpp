// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/place_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace slam {
namespace {

constexpr int kDirections = 12;  // of walls

}  // namespace

PlaceModel floorPlanModel() { return {}; }

PlaceModel scanMapModel() {
  return {.kind = MapKind::kScans,
          .beams = {.sigma = 0.05,
                    .sigma_per_metre = 0.005,
                    .rigid_range = 0.0,
                    .scale_sigma = 0.0,
                    .doorway = 0.0,
                    .extrapolated_rate = 0.0,
                    .stale_free_space = false,
                    .surface_layer = 0.0,
                    .removed_weight = 0.3},
          .unchanged = 0.85,
          .margin_share = 1.0,
          .neighbours = 0};
}

PlaceSearch::PlaceSearch(const PlaceSearchConfig& config) : config_(config) {
  config_.min_margin *= config.model.margin_share;
}

void PlaceSearch::begin(const KeyframeGraph& keyframes, std::span<const int> map) {
  begin();
  field_.emplace(keyframes, map, config_.model.beams, config_.model.kind);
  global_.emplace([&](const auto& visit) { forEachWallPoint(keyframes, map, visit); }, config_.search);
}

void PlaceSearch::begin() {
  looks_.clear();
  under_way_.reset();
  T_map_sessions_.clear();
}

PlaceSearch::Result PlaceSearch::search(const KeyframeGraph& keyframes, int oldest, int newest,
                                        const std::optional<PlaceWindow>& around, double heading_tolerance,
                                        std::int64_t* work) {
  if (!hasMap()) return {};
  if (!under_way_) ask(keyframes, oldest, newest, around, heading_tolerance);
  auto unlimited = std::numeric_limits<std::int64_t>::max();
  std::int64_t& left = work != nullptr ? *work : unlimited;
  global_->goOn(under_way_->search, left);
  if (!under_way_->search.done()) return {.outcome = Outcome::kUnfinished, .T_map_newest = {}};
  const UnderWay done = *std::exchange(under_way_, std::nullopt);
  fitted_rays_ = 0;
  const std::vector<PlaceFit> places = candidates(done);
  Result result = places.empty() ? Result{} : leader(places, done.around.has_value());
  left -= config_.fit_work * fitted_rays_;
  if (result.outcome == Outcome::kFound && !done.search.complete()) result.outcome = Outcome::kAmbiguous;
  // The robot has driven on since it was asked for.
  const Pose2 &asked = looks_.front().T_session_newest, &now = keyframes.pose(newest);
  if (asked.x != now.x || asked.y != now.y || asked.theta != now.theta)
    result.T_map_newest = result.T_map_newest * between(asked, now);
  return result;
}

/// Begins a search for what was seen along the newest path.
void PlaceSearch::ask(const KeyframeGraph& keyframes, int oldest, int newest, const std::optional<PlaceWindow>& around,
                      double heading_tolerance) {
  keyframes.gather(newest, oldest, config_.query_length, config_.max_query_points, query_);
  sampleDirections();
  Look look{{}, keyframes.pose(newest), heading_tolerance};
  look.view.gather(keyframes, oldest, newest, config_.query_length, config_.part_length, field_->model().rigid_range);
  looks_.push_front(std::move(look));
  if (static_cast<int>(looks_.size()) > config_.searches) looks_.pop_back();
  under_way_ = {global_->begin(sample_, config_.min_score, config_.places, config_.place_share, around), around};
}

/// The place that leads all others, by the newest search or in the mean of the last ones. Each place is judged by what
/// all of them saw, whether they found it themselves or not, and lies in the middle of where they put it.
PlaceSearch::Result PlaceSearch::leader(std::span<const PlaceFit> places, bool in_window) {
  struct Contender {
    double sum = 0.0;  // of log-likelihoods
    /// [m, m, rad] sum over the searches, from where the newest one put it
    Eigen::Vector3d moved = Eigen::Vector3d::Zero();
  };
  places = places.first(std::min(places.size(), static_cast<std::size_t>(config_.contenders)));
  std::vector<Contender> contenders(places.size());
  Expected sum;  // over the searches
  Result result{.outcome = Outcome::kAmbiguous, .T_map_newest = {}, .needed = config_.min_margin};
  for (std::size_t searches = 1; searches <= looks_.size(); ++searches) {
    const Look& look = looks_[searches - 1];
    const Pose2 T_newest_look = between(looks_.front().T_session_newest, look.T_session_newest);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Pose2& T_map_newest = places[i].T_map_newest;
      const PlaceFit seen = searches == 1 ? places[i] : fit(look, T_map_newest * T_newest_look, places[i].scale);
      const Pose2 moved = between(T_map_newest, seen.T_map_newest * T_newest_look.inverse());
      contenders[i].sum += seen.log_likelihood;
      contenders[i].moved += Eigen::Vector3d(moved.x, moved.y, moved.theta);
    }
    const auto less = [](const Contender& a, const Contender& b) { return a.sum < b.sum; };
    const auto best = std::max_element(contenders.begin(), contenders.end(), less);
    double second = -std::numeric_limits<double>::infinity();
    for (auto other = contenders.begin(); other != contenders.end(); ++other) {
      if (other != best) second = std::max(second, other->sum);
    }
    const Expected expectation = expected(look.view);
    sum.own += expectation.own;
    sum.unmapped += expectation.unmapped;
    if (!in_window) second = std::max(second, 0.5 * (sum.own + std::max(second, sum.unmapped)));
    const auto n = static_cast<double>(searches);
    const double margin = (best->sum - second) / (n + 1.0);
    if (searches > 1 && margin <= result.margin) continue;
    const Eigen::Vector3d moved = best->moved / n;
    result.T_map_newest = places[static_cast<std::size_t>(best - contenders.begin())].T_map_newest *
                          Pose2{moved.x(), moved.y(), moved.z()};
    result.margin = margin;
    result.T_map_rivals.clear();
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      const bool behind = best->sum - contenders[i].sum >= config_.min_margin * (n + 1.0);
      if (&contenders[i] != &*best && !behind) result.T_map_rivals.push_back(places[i].T_map_newest);
    }
    result.outcome = margin < 0.0 ? Outcome::kElsewhere : Outcome::kAmbiguous;
    if (margin < config_.min_margin) continue;
    result.outcome = Outcome::kFound;
    break;
  }
  return result;
}

/// What a view is expected to have where it was mapped, and where nothing was.
PlaceSearch::Expected PlaceSearch::expected(const QueryCloud& view) const {
  const double rays = view.weight(field_->model()) * view.rays, unchanged = config_.model.unchanged;
  return {.own = rays * (unchanged * field_->logRateWalls() + (1.0 - unchanged) * field_->logRateUnknown()),
          .unmapped = rays * field_->logRateUnknown()};
}

/// The places that the session may have in the map, most likely first, each once: what the search finds, and what it
/// found best the last time.
std::vector<PlaceFit> PlaceSearch::candidates(const UnderWay& done) {
  const Look& look = looks_.front();
  std::vector<PlaceFit> fits;
  for (const GlobalPlace& place : done.search.places()) fits.push_back(fit(look, place.T_map_query, 1.0));
  for (const Pose2& T_map_session : T_map_sessions_) {
    const Pose2 T_map_newest = T_map_session * look.T_session_newest;
    if (!done.around || done.around->holds(T_map_newest)) fits.push_back(fit(look, T_map_newest, 1.0));
  }
  const std::vector<PlaceFit> places = fitBeside(fitScale(each(std::move(fits))), done.around);
  T_map_sessions_.clear();
  for (const PlaceFit& place : places) {
    if (static_cast<int>(T_map_sessions_.size()) == config_.contenders) break;
    T_map_sessions_.push_back(place.T_map_newest * look.T_session_newest.inverse());
  }
  return places;
}

/// The places, likeliest first, each once.
std::vector<PlaceFit> PlaceSearch::each(std::vector<PlaceFit> places) const {
  std::sort(places.begin(), places.end(),
            [](const PlaceFit& a, const PlaceFit& b) { return a.log_likelihood > b.log_likelihood; });
  std::vector<PlaceFit> others;
  for (const PlaceFit& place : places) {
    const bool known = std::any_of(others.begin(), others.end(),
                                   [&](const PlaceFit& other) { return same(other.T_map_newest, place.T_map_newest); });
    if (!known) others.push_back(place);
  }
  return others;
}

/// Lays a view, were it so much longer, at the price of how unlikely that is. So has a place its price where the
/// session's heading is another one: a gyro turns with who carries a robot, unless it is tilted.
PlaceFit PlaceSearch::fit(const Look& look, const Pose2& T_map_newest, double scale) {
  fitted_rays_ += look.view.rays;
  const bool longer = scale != 1.0;
  const auto laid = [&](const QueryCloud& view) { return fitPlace(*field_, view, T_map_newest, config_.fit); };
  PlaceFit fit = longer ? laid(look.view.scaled(scale)) : laid(look.view);
  const double sigmas = longer ? (scale - 1.0) / field_->model().scale_sigma : 0.0;
  fit.scale = scale;
  fit.log_likelihood -= 0.5 * sigmas * sigmas;
  const double turned = std::abs(wrapAngle(fit.T_map_newest.theta - look.T_session_newest.theta));
  if (turned > look.heading_tolerance) fit.log_likelihood -= config_.against_gyro;
  return fit;
}

/// Fits the best places again, were the map as much longer or shorter as it may well be: walls far ahead and the way
/// to walls long passed then agree with each other.
std::vector<PlaceFit> PlaceSearch::fitScale(std::vector<PlaceFit> places) {
  const double sigma = field_->model().scale_sigma;
  if (sigma <= 0.0) return places;
  for (std::size_t i = 0; i < std::min(places.size(), static_cast<std::size_t>(config_.scaled_places)); ++i) {
    const Pose2 T_map_newest = places[i].T_map_newest;
    for (const double scale : {1.0 - sigma, 1.0 + sigma}) {
      const PlaceFit scaled = fit(looks_.front(), T_map_newest, scale);
      if (scaled.log_likelihood > places[i].log_likelihood) places[i] = scaled;
    }
  }
  return each(std::move(places));
}

/// Fits the best places again beside where the search found them: along a corridor its score is flat, and what lies a
/// door further on must not be forgotten because of it.
std::vector<PlaceFit> PlaceSearch::fitBeside(std::vector<PlaceFit> places, const std::optional<PlaceWindow>& around) {
  if (config_.model.neighbours == 0) return places;
  const std::size_t count = std::min(places.size(), static_cast<std::size_t>(config_.model.neighbours));
  for (std::size_t i = 0; i < count; ++i) {
    const PlaceFit place = places[i];
    for (const double steps : {-2.0, -1.0, 1.0, 2.0}) {
      const double by = steps * config_.neighbour_step;
      for (const Pose2& T_place_beside : {Pose2{by, 0.0, 0.0}, Pose2{0.0, by, 0.0}}) {
        const Pose2 T_map_newest = place.T_map_newest * T_place_beside;
        if (!around || around->holds(T_map_newest)) places.push_back(fit(looks_.front(), T_map_newest, place.scale));
      }
    }
  }
  return each(std::move(places));
}

bool PlaceSearch::same(const Pose2& a, const Pose2& b) const {
  const Pose2 gap = between(a, b);
  return std::hypot(gap.x, gap.y) < config_.same_distance && std::abs(gap.theta) < config_.same_rotation;
}

/// Fills sample_: each direction of wall gives as many points, as far as it has them.
void PlaceSearch::sampleDirections() {
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

}  // namespace slam
