// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/decay_rate_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>

#include "relocalisation/wall_extrapolation.hpp"

namespace slam {
namespace {

constexpr int kLevels = 3;
constexpr double kLowest = -6.0;    // log of [1/m]
constexpr double kStep = 0.04;      // of a level's value: log rates from -6 to 4.2
constexpr int kWallDirections = 8;  // that a wall with a door in it may have

}  // namespace

DecayRateMap::DecayRateMap(const KeyframeGraph& keyframes, std::span<const int> map, const BeamModel& model,
                           MapKind kind)
    : walls_(keyframes, map,
             {.kind = kind, .margin = model.extrapolated_rate > 0.0 ? WallExtrapolationConfig{}.length : 0.0}),
      model_(model),
      unknown_rate_(model.rate_unknown),
      log_rate_walls_(std::log(model.rate_unknown)),
      wall_threshold_(std::log(model.at_wall * model.rate_unknown)) {
  const double thickness = walls_.thickness();
  if (thickness <= 0.0) return;
  wall_rate_ = -model.logThrough() / thickness;
  unknown_rate_ = std::max(model.rate_unknown, model.unknown_as_wall * wall_rate_);
  const std::vector<float> wall = look();
  for (int i = 0; i < kLevels; ++i) levels_.push_back(blurred(wall, (1 << i) * model.sigma));
  log_rate_walls_ = meanOfWalls(levels_.front());
  for (int i = 1; i < kLevels; ++i) {  // where sigmaAt() is the geometric mean of two levels
    coarser_.push_back(model.sigma * std::sqrt(std::exp2(2 * i - 1) - 1.0) / model.sigma_per_metre);
  }
}

/// Way [m] from the middle of a cell through free space to a wall no further away than a door is wide.
std::optional<double> DecayRateMap::toWall(int column, int row, const Eigen::Vector2d& direction) const {
  const double cell = walls_.cell();
  for (double s = cell; s <= model_.doorway_width; s += 0.5 * cell) {
    const DistanceField::Known known = walls_.known(column + static_cast<int>(std::lround(s / cell * direction.x())),
                                                    row + static_cast<int>(std::lround(s / cell * direction.y())));
    if (known == DistanceField::Known::kSolid) return s;
    if (known != DistanceField::Known::kFree) break;
  }
  return std::nullopt;
}

/// Whether a free cell lies between two walls that are no further apart than a door is wide, with free space before
/// and behind it.
bool DecayRateMap::isDoorway(int column, int row) const {
  static const auto kAlong = [] {
    std::array<Eigen::Vector2d, kWallDirections> along;
    for (int i = 0; i < kWallDirections; ++i) {
      const double angle = i * std::numbers::pi / kWallDirections;
      along[static_cast<std::size_t>(i)] = {std::cos(angle), std::sin(angle)};
    }
    return along;
  }();
  for (const Eigen::Vector2d& along : kAlong) {
    const auto one = toWall(column, row, along);
    if (!one) continue;
    const auto other = toWall(column, row, -along);
    if (!other || *one + *other > model_.doorway_width) continue;
    bool open = true;
    for (double s = walls_.cell(); s <= model_.before_door; s += 0.5 * walls_.cell()) {
      const int c = static_cast<int>(std::lround(s / walls_.cell() * -along.y()));
      const int r = static_cast<int>(std::lround(s / walls_.cell() * along.x()));
      open &= walls_.known(column + c, row + r) == DistanceField::Known::kFree;
      open &= walls_.known(column - c, row - r) == DistanceField::Known::kFree;
    }
    if (open) return true;
  }
  return false;
}

/// Whether the middle of a wall's cell is no deeper than model_.surface_layer of a wall's thickness below free space.
bool DecayRateMap::inSurfaceLayer(int column, int row) const {
  const int reach = static_cast<int>(std::ceil(model_.surface_layer * walls_.thickness() / walls_.cell() - 0.5));
  for (int r = -reach; r <= reach; ++r) {
    const int across = reach - std::abs(r);
    for (int c = -across; c <= across; ++c) {
      if (walls_.known(column + c, row + r) == DistanceField::Known::kFree) return true;
    }
  }
  return false;
}

/// Fills surface_layer_.
/// @return [1] of a wall's rate, by cell
std::vector<float> DecayRateMap::look() {
  const int columns = walls_.columns(), rows = walls_.rows();
  std::vector<float> wall(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0.0F);
  surface_layer_.assign(wall.size(), false);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::size_t cell = walls_.index(column, row);
      const DistanceField::Known known = walls_.known(cell);
      if (known == DistanceField::Known::kSolid) {
        wall[cell] = 1.0F;
        surface_layer_[cell] = inSurfaceLayer(column, row);
      } else if (known == DistanceField::Known::kFree && model_.doorway > 0.0 && isDoorway(column, row)) {
        wall[cell] = static_cast<float>(model_.doorway);
      }
    }
  }
  if (model_.extrapolated_rate > 0.0) {
    for (const std::size_t cell : extrapolatedWalls(walls_)) wall[cell] = static_cast<float>(model_.extrapolated_rate);
  }
  return wall;
}

/// A level: the walls' rate under a Gaussian, and that of the space around them.
std::vector<std::uint8_t> DecayRateMap::blurred(const std::vector<float>& wall, double sigma) const {
  const int columns = walls_.columns(), rows = walls_.rows();
  const int reach = static_cast<int>(std::ceil(model_.blur_sigmas * sigma / walls_.cell()));
  std::vector<float> kernel(static_cast<std::size_t>(2 * reach + 1));
  float sum = 0.0F;
  for (int i = -reach; i <= reach; ++i) {
    const double u = i * walls_.cell() / sigma;
    sum += kernel[static_cast<std::size_t>(i + reach)] = static_cast<float>(std::exp(-0.5 * u * u));
  }
  for (float& k : kernel) k /= sum;
  const auto value = [](double rate) {
    return static_cast<std::uint8_t>(std::clamp(std::lround((std::log(rate) - kLowest) / kStep), 0L, 255L));
  };
  const std::uint8_t unknown = value(unknown_rate_),
                     free = value(model_.rate_free);  // far from walls, as most cells are
  // Each solid cell is spread over its row, then each row over those around it: most of a map is not solid. Of the rows
  // that were spread only those are kept that the next ones need.
  const auto window = static_cast<int>(kernel.size());
  std::vector<std::vector<float>> along(kernel.size());
  const auto spreadRow = [&](int row) {
    std::vector<float>& to = along[static_cast<std::size_t>(row % window)];
    to.assign(static_cast<std::size_t>(columns), 0.0F);
    for (int column = 0; column < columns; ++column) {
      const float rate = wall[walls_.index(column, row)];
      if (rate == 0.0F) continue;
      for (int c = std::max(0, column - reach); c <= std::min(columns - 1, column + reach); ++c)
        to[static_cast<std::size_t>(c)] += rate * kernel[static_cast<std::size_t>(c - column + reach)];
    }
  };
  std::vector<std::uint8_t> level(wall.size());
  std::vector<float> both(static_cast<std::size_t>(columns));
  for (int row = 0, spread = 0; row < rows; ++row) {
    for (; spread < std::min(rows, row + reach + 1); ++spread) spreadRow(spread);
    std::fill(both.begin(), both.end(), 0.0F);
    for (int r = std::max(0, row - reach); r < spread; ++r) {
      const std::vector<float>& from = along[static_cast<std::size_t>(r % window)];
      const float share = kernel[static_cast<std::size_t>(row - r + reach)];
      for (std::size_t c = 0; c < both.size(); ++c) both[c] += from[c] * share;
    }
    for (std::size_t c = 0; c < both.size(); ++c) {
      const std::size_t i = walls_.index(static_cast<int>(c), row);
      const bool is_unknown = walls_.known(i) == DistanceField::Known::kNothing;
      if (both[c] == 0.0F) {
        level[i] = is_unknown ? unknown : free;
      } else {
        level[i] = value(wall_rate_ * static_cast<double>(both[c]) + (is_unknown ? unknown_rate_ : model_.rate_free));
      }
    }
  }
  return level;
}

double DecayRateMap::meanOfWalls(const std::vector<std::uint8_t>& level) const {
  double sum = 0.0;
  std::int64_t count = 0;
  for (std::size_t i = 0; i < level.size(); ++i) {
    if (walls_.known(i) != DistanceField::Known::kSolid) continue;
    sum += kLowest + kStep * level[i];
    ++count;
  }
  return sum / static_cast<double>(std::max<std::int64_t>(1, count));
}

std::size_t DecayRateMap::levelOf(double range) const {
  return static_cast<std::size_t>(std::upper_bound(coarser_.begin(), coarser_.end(), range) - coarser_.begin());
}

double DecayRateMap::logRate(const Eigen::Vector2d& p_map, double range) const {
  const auto i = levels_.empty() ? -1 : walls_.index(p_map);
  if (i < 0) return std::log(unknown_rate_);
  return kLowest + kStep * levels_[levelOf(range)][static_cast<std::size_t>(i)];
}

double DecayRateMap::pass(const Eigen::Vector2d& from, const Eigen::Vector2d& to, std::vector<Passed>& passed) const {
  const Eigen::Vector2d ray = to - from;
  const double range = ray.norm(), cell = walls_.cell();
  const double end = range - model_.end_sigmas * model_.sigmaAt(range) - model_.roughness;
  const Eigen::Vector2d direction = ray / range;
  double sum = 0.0, deep = 0.0;  // deep: [m] square to its face, since the beam came into a wall
  for (double s = model_.from_lidar; s < end;) {
    const Eigen::Vector2d p = from + s * direction;
    const auto i = walls_.index(p);
    if (i < 0) {  // outside the map
      s += cell;
      continue;
    }
    const DistanceField::Wall* wall = walls_.nearest(p);
    if (walls_.known(static_cast<std::size_t>(i)) != DistanceField::Known::kSolid) {
      const double distance = wall == nullptr ? walls_.reach() : (wall->position - p).norm();
      s += std::max(cell, distance - 2.0 * cell);
      deep = 0.0;
      continue;
    }
    const double square = wall != nullptr && wall->isLine() ? std::abs(direction.dot(wall->normal)) : 1.0;
    deep += cell * square;
    s += cell;
    if (surface_layer_[static_cast<std::size_t>(i)] && deep <= walls_.thickness()) continue;
    passed.push_back({i, -wall_rate_ * cell * square});
    sum += passed.back().log_through;
  }
  return sum;
}

double DecayRateMap::logPassed(std::vector<Passed>& passed) const {
  std::sort(passed.begin(), passed.end(), [](const Passed& a, const Passed& b) {
    return std::tie(a.cell, a.log_through) < std::tie(b.cell, b.log_through);
  });
  double sum = 0.0;
  for (std::size_t i = 0; i < passed.size(); ++i) {
    if (i == 0 || passed[i].cell != passed[i - 1].cell) sum += passed[i].log_through;
  }
  return model_.removed_weight * sum;
}

}  // namespace slam
