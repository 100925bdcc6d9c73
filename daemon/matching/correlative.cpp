// SPDX-License-Identifier: BSD-3-Clause
#include "matching/correlative.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "matching/plicp.hpp"

namespace slam {
namespace {}  // namespace

CorrelativeMatcher::CorrelativeMatcher(const CorrelativeConfig& config) : config_(config) {
  sample_.reserve(static_cast<std::size_t>(config.max_points));
  rotated_.resize(static_cast<std::size_t>(config.max_points));
  best_.reserve(static_cast<std::size_t>(config.refined) + 1);
}

SearchResult CorrelativeMatcher::match(const Reference& reference, std::span<const ScanPoint> points,
                                       const Pose2& guess, const SearchWindow& window,
                                       const MatchConfig& config) noexcept {
  SearchResult result;
  result.match = {.status = MatchStatus::kTooFewPairs, .T_ref_base = guess};
  if (static_cast<int>(points.size()) < config.min_pairs) return result;
  sample(points);
  const double step = scoreAll(reference, guess, window, meanRange(points));

  MatchConfig narrow = config;  // the steps leave less to be found than a first guess does
  narrow.initial_pair_distance = std::max(narrow.final_pair_distance, config_.reach * step);
  narrow.search_translation = narrow.search_rotation = 0.0;
  MatchResult second;
  const auto better = [](const MatchResult& a, const MatchResult& b) {
    return a.usable() != b.usable() ? a.usable() : a.overlap > b.overlap;
  };
  const auto elsewhere = [&](const Pose2& a, const Pose2& b) {
    return std::hypot(a.x - b.x, a.y - b.y) > config_.distinct_distance ||
           std::abs(wrapAngle(a.theta - b.theta)) > config_.distinct_rotation;
  };
  for (const Hypothesis& hypothesis : best_) {
    const MatchResult refined = matchPointToLine(reference, points, hypothesis.T_ref_base, narrow);
    if (better(refined, result.match)) {
      if (result.match.usable() && elsewhere(refined.T_ref_base, result.match.T_ref_base)) second = result.match;
      result.match = refined;
    } else if (refined.usable() && elsewhere(refined.T_ref_base, result.match.T_ref_base) && better(refined, second)) {
      second = refined;
    }
  }
  if (!result.match.usable()) return result;
  if (result.match.observable < 3) slide(reference, window.translation, result.match);
  if (second.usable() && elsewhere(second.T_ref_base, result.match.T_ref_base)) {
    result.runner_up = second.overlap / result.match.overlap;
  }
  if (result.runner_up > config_.ambiguity) result.match.status = MatchStatus::kAmbiguous;
  return result;
}

SearchResult CorrelativeMatcher::matchOrSearch(const Reference& reference, std::span<const ScanPoint> points,
                                               const Pose2& guess, const SearchWindow& window,
                                               const MatchConfig& config) noexcept {
  SearchResult direct{.match = matchPointToLine(reference, points, guess, config)};
  if (direct.match.usable() && direct.match.overlap >= config_.trusted_overlap) {
    if (direct.match.observable < 3) {
      sample(points);
      slide(reference, window.translation, direct.match);
    }
    return direct;
  }
  SearchResult searched = match(reference, points, guess, window, config);
  const bool found = searched.match.usable() || searched.match.status == MatchStatus::kAmbiguous;
  const bool better = !direct.match.usable() || searched.match.overlap > direct.match.overlap - config_.same_overlap;
  return found && better ? searched : direct;
}

void CorrelativeMatcher::sample(std::span<const ScanPoint> points) {
  const std::size_t count = std::min(points.size(), static_cast<std::size_t>(config_.max_points));
  sample_.clear();
  for (std::size_t i = 0; i < count; ++i) sample_.push_back(points[i * points.size() / count].position);
}

double CorrelativeMatcher::scoreAll(const Reference& reference, const Pose2& guess, const SearchWindow& window,
                                    double lever) {
  // Odd numbers of steps, so that the guess itself is among the hypotheses.
  double step = config_.translation_step;
  int turns = 0, shifts = 0;
  for (;; step *= 1.25) {
    turns = static_cast<int>(std::ceil(std::min(window.rotation, std::numbers::pi) * lever / step));
    shifts = static_cast<int>(std::ceil(window.translation / step));
    if ((2.0 * turns + 1) * (2.0 * shifts + 1) * (2.0 * shifts + 1) <= config_.max_hypotheses) break;
  }
  const double kernel = std::max(config_.kernel_scale, step);
  best_.clear();
  for (int turn = -turns; turn <= turns; ++turn) {
    const double theta = wrapAngle(guess.theta + turn * step / lever);
    const Pose2 rotation{0.0, 0.0, theta};
    for (std::size_t i = 0; i < sample_.size(); ++i) rotated_[i] = rotation * sample_[i];
    for (int row = -shifts; row <= shifts; ++row) {
      for (int column = -shifts; column <= shifts; ++column) {
        const Eigen::Vector2d t(guess.x + column * step, guess.y + row * step);
        keepBest({{t.x(), t.y(), theta}, score(reference, t, kernel), turn, column, row});
      }
    }
  }
  return step;
}

float CorrelativeMatcher::score(const Reference& reference, const Eigen::Vector2d& translation, double kernel) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < sample_.size(); ++i) {
    const Eigen::Vector2d p = rotated_[i] + translation;
    const Surfel* surfel = reference.nearest(p, kernel);
    if (surfel == nullptr) continue;
    const double dx = p.x() - surfel->x, dy = p.y() - surfel->y;
    sum += std::max(0.0, 1.0 - (dx * dx + dy * dy) / (kernel * kernel));
  }
  return static_cast<float>(sum / static_cast<double>(sample_.size()));
}

void CorrelativeMatcher::slide(const Reference& reference, double reach, MatchResult& match) {
  const Eigen::Vector2d along = match.directions.col(2).head<2>();
  if (match.observable != 2 || along.norm() < config_.mostly_translation) return;
  const Pose2 rotation{0.0, 0.0, match.T_ref_base.theta};
  for (std::size_t i = 0; i < sample_.size(); ++i) rotated_[i] = rotation * sample_[i];
  const Eigen::Vector2d start = match.T_ref_base.translation(), direction = along.normalized();
  const int steps = static_cast<int>(std::ceil(reach / config_.slide_step));
  float best = score(reference, start, config_.slide_kernel) + config_.clear_gain;
  for (int i = -steps; i <= steps; ++i) {
    const Eigen::Vector2d t = start + i * config_.slide_step * direction;
    const float there = score(reference, t, config_.slide_kernel);
    if (there <= best) continue;
    best = there;
    match.T_ref_base.x = t.x();
    match.T_ref_base.y = t.y();
  }
}

void CorrelativeMatcher::keepBest(const Hypothesis& hypothesis) {
  if (static_cast<int>(best_.size()) == config_.refined && hypothesis.score <= best_.back().score) return;
  const auto adjacent = [&](const Hypothesis& other) {
    return std::abs(other.turn - hypothesis.turn) <= 1 && std::abs(other.column - hypothesis.column) <= 1 &&
           std::abs(other.row - hypothesis.row) <= 1;
  };
  // A neighbour of a better hypothesis is the same hill; of worse ones it takes the place.
  if (std::any_of(best_.begin(), best_.end(),
                  [&](const Hypothesis& other) { return adjacent(other) && other.score >= hypothesis.score; })) {
    return;
  }
  std::erase_if(best_, adjacent);
  const auto place =
      std::find_if(best_.begin(), best_.end(), [&](const Hypothesis& other) { return other.score < hypothesis.score; });
  best_.insert(place, hypothesis);
  if (static_cast<int>(best_.size()) > config_.refined) best_.pop_back();
}

}  // namespace slam
