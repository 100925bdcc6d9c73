// SPDX-License-Identifier: BSD-3-Clause
#include "posegraph/decay_field.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace slam {
namespace {

constexpr int kLevels = 3;
constexpr double kSigmas = 3.0;      // of the blur
constexpr double kLowest = -6.0;     // log of [1/m]
constexpr double kStep = 0.04;       // of a level's value: log rates from -6 to 4.2
constexpr double kEndSigmas = 2.0;   // before its end a beam may be within the wall that it ended at ...
constexpr double kRoughness = 0.1;   // [m] ... and so much more
constexpr double kFromLidar = 0.15;  // [m] that the robot itself fills
constexpr double kAtWall = 2.0;      // times the rate of unknown space

}  // namespace

DecayField::DecayField(const KeyframeGraph& keyframes, std::span<const int> map, const BeamModel& model)
    : walls_(keyframes, map),
      model_(model),
      unknown_rate_(model.rate_unknown),
      wall_threshold_(std::log(kAtWall * model.rate_unknown)) {
  const double thickness = walls_.thickness();
  if (thickness <= 0.0) return;
  wall_rate_ = -model.logThrough() / thickness;
  unknown_rate_ = std::max(model.rate_unknown, model.unknown_as_wall * wall_rate_);
  levels_.resize(kLevels);
  for (int i = 0; i < kLevels; ++i) blur((1 << i) * model.sigma, levels_[static_cast<std::size_t>(i)]);
  for (int i = 1; i < kLevels; ++i) {  // where sigmaAt() is the geometric mean of two levels
    coarser_.push_back(model.sigma * std::sqrt(std::exp2(2 * i - 1) - 1.0) / model.sigma_per_metre);
  }
}

/// Fills a level: the walls' rate under a Gaussian, and that of the space around them.
void DecayField::blur(double sigma, std::vector<std::uint8_t>& level) const {
  const int columns = walls_.columns(), rows = walls_.rows();
  const int reach = static_cast<int>(std::ceil(kSigmas * sigma / walls_.cell()));
  std::vector<float> kernel(static_cast<std::size_t>(2 * reach + 1));
  float sum = 0.0F;
  for (int i = -reach; i <= reach; ++i) {
    const double u = i * walls_.cell() / sigma;
    sum += kernel[static_cast<std::size_t>(i + reach)] = static_cast<float>(std::exp(-0.5 * u * u));
  }
  for (float& k : kernel) k /= sum;
  const auto at = [&](int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
  };
  // Each solid cell is spread over its row, then each row over its column: most of a map is not solid.
  std::vector<float> along(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0.0F),
      both(along.size());
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (walls_.known(at(column, row)) != WallField::Known::kSolid) continue;
      for (int c = std::max(0, column - reach); c <= std::min(columns - 1, column + reach); ++c) {
        along[at(c, row)] += kernel[static_cast<std::size_t>(c - column + reach)];
      }
    }
  }
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const float value = along[at(column, row)];
      if (value == 0.0F) continue;
      for (int r = std::max(0, row - reach); r <= std::min(rows - 1, row + reach); ++r) {
        both[at(column, r)] += value * kernel[static_cast<std::size_t>(r - row + reach)];
      }
    }
  }
  level.resize(both.size());
  for (std::size_t i = 0; i < both.size(); ++i) {
    const double around = walls_.known(i) == WallField::Known::kNothing ? unknown_rate_ : model_.rate_free;
    const double log_rate = std::log(wall_rate_ * static_cast<double>(both[i]) + around);
    level[i] = static_cast<std::uint8_t>(std::clamp(std::lround((log_rate - kLowest) / kStep), 0L, 255L));
  }
}

std::size_t DecayField::levelOf(double range) const {
  return static_cast<std::size_t>(std::upper_bound(coarser_.begin(), coarser_.end(), range) - coarser_.begin());
}

double DecayField::logRate(const Eigen::Vector2d& p_map, double range) const {
  const auto i = levels_.empty() ? -1 : walls_.index(p_map);
  if (i < 0) return std::log(unknown_rate_);
  return kLowest + kStep * levels_[levelOf(range)][static_cast<std::size_t>(i)];
}

double DecayField::pass(const Eigen::Vector2d& from, const Eigen::Vector2d& to, std::vector<Passed>& passed) const {
  const Eigen::Vector2d ray = to - from;
  const double range = ray.norm(), cell = walls_.cell();
  const double end = range - kEndSigmas * model_.sigmaAt(range) - kRoughness;
  const Eigen::Vector2d direction = ray / range;
  const int patch = std::max(1, static_cast<int>(std::lround(model_.gone_patch / cell)));
  double sum = 0.0;
  for (double s = kFromLidar; s < end;) {
    const Eigen::Vector2d p = from + s * direction;
    const auto i = walls_.index(p);
    if (i < 0) {  // outside the map
      s += cell;
      continue;
    }
    const WallField::Wall* wall = walls_.nearest(p);
    if (walls_.known(static_cast<std::size_t>(i)) != WallField::Known::kSolid) {
      const double distance = wall == nullptr ? walls_.reach() : (wall->position - p).norm();
      s += std::max(cell, distance - 2.0 * cell);
      continue;
    }
    const double square = wall != nullptr && wall->isLine() ? std::abs(direction.dot(wall->normal)) : 1.0;
    const std::int64_t column = i % walls_.columns(), row = i / walls_.columns();
    passed.push_back({row / patch * walls_.columns() + column / patch, i, -wall_rate_ * cell * square});
    sum += passed.back().log_through;
    s += cell;
  }
  return sum;
}

double DecayField::logPassed(std::vector<Passed>& passed) const {
  std::sort(passed.begin(), passed.end(), [](const Passed& a, const Passed& b) {
    return std::tie(a.patch, a.cell, a.log_through) < std::tie(b.patch, b.cell, b.log_through);
  });
  const double least = model_.gone_most * model_.logThrough();
  double sum = 0.0, patch = 0.0;
  for (std::size_t i = 0; i < passed.size(); ++i) {
    if (i > 0 && passed[i].patch != passed[i - 1].patch) sum += std::max(least, std::exchange(patch, 0.0));
    if (i == 0 || passed[i].cell != passed[i - 1].cell) patch += passed[i].log_through;
  }
  return model_.gone_weight * (sum + std::max(least, patch));
}

}  // namespace slam
