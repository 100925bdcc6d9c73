// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/global_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace slam {
namespace {

constexpr double kFull = 255.0;  // of a level's value

int floorDivide(int value, int by) { return value >= 0 ? value / by : -((by - 1 - value) / by); }

}  // namespace

GlobalSearch::GlobalSearch(std::span<const Eigen::Vector2d> walls, const GlobalSearchConfig& config)
    : GlobalSearch([walls](const auto& visit) { std::for_each(walls.begin(), walls.end(), visit); }, config) {}

GlobalSearch::GlobalSearch(const Walls& walls, const GlobalSearchConfig& config) : config_(config), cell_(config.cell) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  walls([&](const Eigen::Vector2d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  });
  if (!low.allFinite()) return;
  // A margin on all sides takes the kernel and lets a coarse level look beyond the border.
  const Eigen::Vector2d size = high - low;
  cell_ = std::max(config.cell, std::sqrt(size.x() * size.y() / config.max_cells));
  margin_ =
      (1 << (config.levels - 1)) + static_cast<int>(std::ceil(config.kernel_sigmas * config.kernel_sigma / cell_));
  columns_ = static_cast<int>(std::ceil(size.x() / cell_)) + 1 + 2 * margin_;
  rows_ = static_cast<int>(std::ceil(size.y() / cell_)) + 1 + 2 * margin_;
  origin_ = low - Eigen::Vector2d::Constant(margin_ * cell_);

  levels_.resize(static_cast<std::size_t>(config.levels));
  levels_[0] = {.reach = 1, .values = smoothed(walls)};
  for (std::size_t level = 1; level < levels_.size(); ++level) addLevel(level);
  const std::vector<std::uint8_t> coarsest = std::move(levels_.back().values);
  const int step = coarsest_.step = levels_.back().reach;
  coarsest_.columns = (columns_ + step - 1) / step;
  coarsest_.rows = (rows_ + step - 1) / step;
  coarsest_.values.assign(coarsest_.planeSize() * static_cast<std::size_t>(step * step), 0);
  for (int r = 0; r < rows_; ++r) {
    for (int c = 0; c < columns_; ++c) {
      const auto at = static_cast<std::size_t>(r / step * coarsest_.columns + c / step);
      coarsest_.values[coarsest_.begin(c % step, r % step) + at] = coarsest[index(c, r)];
    }
  }
}

std::vector<std::uint8_t> GlobalSearch::smoothed(const Walls& walls) const {
  const auto cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  const int disc = static_cast<int>(std::ceil(config_.kernel_sigmas * config_.kernel_sigma / cell_));
  std::vector<double> nearest(cells, std::numeric_limits<double>::infinity());  // squared, in cells
  std::vector<double> across(static_cast<std::size_t>(2 * disc + 1));
  walls([&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d at = (p - origin_) / cell_;
    const int left = static_cast<int>(at.x()) - disc, bottom = static_cast<int>(at.y()) - disc;
    for (std::size_t i = 0; i < across.size(); ++i) across[i] = square(left + static_cast<int>(i) + 0.5 - at.x());
    for (int r = bottom; r <= bottom + 2 * disc; ++r) {
      const double along = square(r + 0.5 - at.y());
      double* row = &nearest[index(left, r)];
      for (std::size_t i = 0; i < across.size(); ++i) row[i] = std::min(row[i], across[i] + along);
    }
  });
  std::vector<std::uint8_t> values(cells, 0);
  for (std::size_t i = 0; i < cells; ++i) {
    if (std::isinf(nearest[i])) continue;
    const double distance = cell_ * std::sqrt(nearest[i]) / config_.kernel_sigma;
    if (distance > config_.kernel_sigmas) continue;
    values[i] = static_cast<std::uint8_t>(kFull * std::exp(-0.5 * distance * distance));
  }
  return values;
}

/// The maximum of four of the level below: of two beside each other, and then of two of those.
void GlobalSearch::addLevel(std::size_t level) {
  const auto width = static_cast<std::size_t>(columns_);
  const Level& below = levels_[level - 1];
  const auto reach = static_cast<std::size_t>(below.reach);
  levels_[level].reach = 2 * below.reach;
  levels_[level].values.resize(below.values.size());
  for (int r = 0; r < rows_; ++r) {
    const std::uint8_t* from = &below.values[index(0, r)];
    std::uint8_t* to = &levels_[level].values[index(0, r)];
    for (std::size_t c = 0; c + reach < width; ++c) to[c] = std::max(from[c], from[c + reach]);
    for (std::size_t c = width - reach; c < width; ++c) to[c] = std::max(from[c], from[width - 1]);
  }
  for (int r = 0; r < rows_; ++r) {
    const std::uint8_t* from = &levels_[level].values[index(0, std::min(r + below.reach, rows_ - 1))];
    std::uint8_t* to = &levels_[level].values[index(0, r)];
    for (std::size_t c = 0; c < width; ++c) to[c] = std::max(to[c], from[c]);
  }
}

bool PlaceWindow::holds(const Pose2& pose) const {
  return std::abs(pose.x - T_map_query.x) <= translation && std::abs(pose.y - T_map_query.y) <= translation &&
         std::abs(wrapAngle(pose.theta - T_map_query.theta)) <= rotation;
}

/// Keeps the better half, where there is no room for all.
void GlobalSearch::Search::leaveOutWorst(std::size_t max_open) {
  if (open_.size() <= max_open) return;
  const auto kept = open_.begin() + static_cast<std::ptrdiff_t>(max_open / 2);
  std::nth_element(open_.begin(), kept, open_.end(), [](const Block& a, const Block& b) { return b < a; });
  left_out_ = std::max(left_out_, std::max_element(kept, open_.end(), [](const Block& a, const Block& b) {
                                    return a.bound < b.bound;
                                  })->bound);
  open_.erase(kept, open_.end());
}

GlobalSearch::Search GlobalSearch::begin(std::span<const Eigen::Vector2d> points, double min_score, int most,
                                         double share, const std::optional<PlaceWindow>& around) const {
  Search search;
  search.done_ = levels_.empty() || points.empty();
  if (search.done_) return search;
  search.most_ = most;
  search.share_ = share;
  search.around_ = around;
  Query& query = search.query_;
  query.count = static_cast<int>(points.size());
  double sum = 0.0;
  for (const Eigen::Vector2d& p : points) sum += p.norm();
  const double lever = std::max(1.0, sum / query.count);
  query.turns = static_cast<int>(std::ceil(2.0 * std::numbers::pi * lever / (config_.turn_step * cell_)));
  query.step = 2.0 * std::numbers::pi / query.turns;
  query.points.reserve(static_cast<std::size_t>(query.turns) * points.size());
  for (int turn = 0; turn < query.turns; ++turn) {
    const double c = std::cos(turn * query.step) / cell_, s = std::sin(turn * query.step) / cell_;
    for (const Eigen::Vector2d& p : points) {
      query.points.push_back({static_cast<int>(std::floor(c * p.x() - s * p.y() + 0.5)),
                              static_cast<int>(std::floor(s * p.x() + c * p.y() + 0.5))});
    }
  }
  search.threshold_ = static_cast<int>(min_score * (kFull * query.count));
  return search;
}

std::vector<GlobalPlace> GlobalSearch::search(std::span<const Eigen::Vector2d> points, double min_score, int most,
                                              double share, const std::optional<PlaceWindow>& around) const {
  Search search = begin(points, min_score, most, share, around);
  auto work = std::numeric_limits<std::int64_t>::max();
  goOn(search, work);
  return {search.places().begin(), search.places().end()};
}

void GlobalSearch::goOn(Search& search, std::int64_t& work) const {
  const Query& query = search.query_;
  std::vector<Block>& open = search.open_;
  while (!search.done_ && search.turn_ < query.turns) {
    if (work <= 0) return;
    addCoarseBlocks(search, work);
    search.leaveOutWorst(config_.max_open);
    if (++search.turn_ == query.turns) std::make_heap(open.begin(), open.end());
  }
  // Best first: a pose that comes out on top scores no less than any block's bound.
  const double full = kFull * query.count;
  while (!search.done_) {
    if (work <= 0) return;
    work -= config_.block_work;
    search.done_ = open.empty() || search.full() || open.front().bound <= search.threshold_;
    if (search.done_) break;
    std::pop_heap(open.begin(), open.end());
    const Block block = open.back();
    open.pop_back();
    if (!elsewhere(query, block.pose, levels_[static_cast<std::size_t>(block.level)].reach, search.known_)) continue;
    if (block.level == 0) {
      if (search.around_ && !search.around_->holds(toPose(query, block.pose))) continue;
      if (search.known_.empty())
        search.threshold_ = std::max(search.threshold_, static_cast<int>(search.share_ * block.bound));
      search.known_.push_back(block.pose);
      search.places_.push_back({toPose(query, block.pose), block.bound / full});
      search.last_ = block.bound;
    } else {
      branch(search, block, work);
    }
  }
}

/// Those of the next turn. The query's origin lies within the walls' bounding box.
void GlobalSearch::addCoarseBlocks(Search& search, std::int64_t& work) const {
  const Query& query = search.query_;
  const std::optional<PlaceWindow>& around = search.around_;
  const int turn = search.turn_, coarsest = static_cast<int>(levels_.size()) - 1, step = coarsest_.step;
  int left = margin_, right = columns_ - margin_, bottom = margin_, top = rows_ - margin_;
  if (around) {
    if (std::abs(wrapAngle(turn * query.step - around->T_map_query.theta)) > around->rotation) return;
    const double reach = around->translation / cell_;
    const Eigen::Vector2d middle = (around->T_map_query.translation() - origin_) / cell_;
    left = std::max(left, static_cast<int>(middle.x() - reach));
    right = std::min(right, static_cast<int>(middle.x() + reach) + 1);
    bottom = std::max(bottom, static_cast<int>(middle.y() - reach));
    top = std::min(top, static_cast<int>(middle.y() + reach) + 1);
  }
  const int across = (right - left + step - 1) / step, along = (top - bottom + step - 1) / step;
  if (across <= 0 || along <= 0) return;
  std::vector<int> bounds(static_cast<std::size_t>(across) * static_cast<std::size_t>(along), 0);
  work -= static_cast<std::int64_t>(bounds.size()) * query.count / config_.coarse_at_once;
  for (const Query::Point& point : query.at(turn)) {
    const int column = left + point.column, row = bottom + point.row;
    const int c0 = floorDivide(column, step), r0 = floorDivide(row, step);
    const std::uint8_t* plane = &coarsest_.values[coarsest_.begin(column - c0 * step, row - r0 * step)];
    const int begin = std::max(0, -c0), end = std::min(across, coarsest_.columns - c0);
    for (int r = std::max(0, -r0); r < std::min(along, coarsest_.rows - r0); ++r) {
      const std::uint8_t* values = plane + static_cast<std::ptrdiff_t>(r0 + r) * coarsest_.columns + c0;
      int* sums = &bounds[static_cast<std::size_t>(r) * static_cast<std::size_t>(across)];
      for (int c = begin; c < end; ++c) sums[c] += values[c];
    }
  }
  const int* bound = bounds.data();
  for (int row = bottom; row < top; row += step) {
    for (int column = left; column < right; column += step, ++bound) {
      if (*bound > search.threshold_) search.open_.push_back({{turn, column, row}, coarsest, *bound});
    }
  }
}

void GlobalSearch::branch(Search& search, const Block& block, std::int64_t& work) const {
  const int level = block.level - 1, half = levels_[static_cast<std::size_t>(level)].reach;
  const std::array<int, 4> bounds = scoreQuarters(search.query_, block, search.threshold_, work);
  for (int i = 0; i < 4; ++i) {
    const int bound = bounds[static_cast<std::size_t>(i)];
    if (bound <= search.threshold_) continue;
    search.open_.push_back(
        {{block.pose.turn, block.pose.column + (i & 1) * half, block.pose.row + (i >> 1) * half}, level, bound});
    std::push_heap(search.open_.begin(), search.open_.end());
  }
  if (search.open_.size() <= config_.max_open) return;
  search.leaveOutWorst(config_.max_open);
  std::make_heap(search.open_.begin(), search.open_.end());
}

/// Whether a block of poses, `width` cells wide, holds one that is another place than all that are known.
bool GlobalSearch::elsewhere(const Query& query, const Pose& block, int width, std::span<const Pose> known) const {
  const double cells = square(config_.distinct_distance / cell_);
  return std::all_of(known.begin(), known.end(), [&](const Pose& other) {
    const int turns = std::abs(block.turn - other.turn);
    if (std::min(turns, query.turns - turns) * query.step > config_.distinct_rotation) return true;
    const auto farthest = [&](int from, int to) {
      return std::max(std::abs(from - to), std::abs(from + width - 1 - to));
    };
    const int columns = farthest(block.column, other.column), rows = farthest(block.row, other.row);
    return columns * columns + rows * rows > cells;
  });
}

/// Sums of a level's values under the points, for each quarter of a block of the level above: lower left, lower right,
/// upper left, upper right. Stops where none of them can exceed the threshold any more: under each point the block
/// has the highest of its quarters' values, so that what the points to come give to any quarter is known from above.
std::array<int, 4> GlobalSearch::scoreQuarters(const Query& query, const Block& block, int threshold,
                                               std::int64_t& work) const {
  const int level = block.level - 1;
  const Pose& pose = block.pose;
  const std::uint8_t* values = levels_[static_cast<std::size_t>(level)].values.data();
  const int half = levels_[static_cast<std::size_t>(level)].reach;
  const auto columns = static_cast<unsigned>(columns_ - half), rows = static_cast<unsigned>(rows_ - half);
  const std::size_t right = static_cast<std::size_t>(half), up = right * static_cast<std::size_t>(columns_);
  std::array<int, 4> sums{};
  int left = block.bound;  // of the points to come, at most
  const std::span<const Query::Point> points = query.at(pose.turn);
  for (std::size_t begin = 0; begin < points.size(); begin += config_.points_at_once) {
    const auto some = points.subspan(begin, std::min(config_.points_at_once, points.size() - begin));
    work -= static_cast<std::int64_t>(some.size());
    for (const Query::Point& point : some) {
      const int column = point.column + pose.column, row = point.row + pose.row;
      int a = 0, b = 0, c = 0, d = 0;
      if (static_cast<unsigned>(column) < columns && static_cast<unsigned>(row) < rows) {
        const std::uint8_t* value = values + static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                                    static_cast<std::size_t>(column);
        a = value[0];
        b = value[right];
        c = value[up];
        d = value[up + right];
      } else {
        a = valueAt(values, column, row);
        b = valueAt(values, column + half, row);
        c = valueAt(values, column, row + half);
        d = valueAt(values, column + half, row + half);
      }
      sums[0] += a;
      sums[1] += b;
      sums[2] += c;
      sums[3] += d;
      left -= std::max(std::max(a, b), std::max(c, d));
    }
    if (*std::max_element(sums.begin(), sums.end()) + left <= threshold) return {};
  }
  return sums;
}

Pose2 GlobalSearch::toPose(const Query& query, const Pose& pose) const {
  return {origin_.x() + (pose.column + 0.5) * cell_, origin_.y() + (pose.row + 0.5) * cell_,
          wrapAngle(pose.turn * query.step)};
}

}  // namespace slam
