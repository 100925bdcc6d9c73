// SPDX-License-Identifier: BSD-3-Clause
#include "slam/merge/moved_furniture.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace slam {
namespace {

using Look = ComparedMap::Look;

/// How a piece fits where it is laid in the other map.
struct Fit {
  int recognised = 0, missed = 0;  // [cells]

  int score() const { return recognised - missed; }
};

/// A piece of either map that look alike when one is laid on the other.
struct Twins {
  const Piece *a = nullptr, *b = nullptr;
  Fit a_in_b, b_in_a;

  int score() const { return a_in_b.score() + b_in_a.score(); }
};

class TwinSearch {
 public:
  TwinSearch(const ComparedMap& a, const ComparedMap& b, const MovedFurnitureConfig& config)
      : a_(a), b_(b), config_(config), distance_(config.distance / config.cell) {}

  /// The best place in b of a piece of a, turned by one of these angles [rad], where the piece of b looks like it.
  std::optional<Twins> find(const Piece& a, const Piece& b, std::span<const double> turns) const {
    std::optional<Twins> best;
    const double half_diagonals = ((at(a.high) - at(a.low)).norm() + (at(b.high) - at(b.low)).norm()) / 2.0;
    if ((middleOf(a) - middleOf(b)).norm() > distance_ + half_diagonals) return best;
    for (const double turn : turns) findTurned(a, b, turn, best);
    return best;
  }

 private:
  static Eigen::Vector2d at(CellIndex cell) { return Eigen::Vector2d(cell.column, cell.row); }

  static Eigen::Vector2d middleOf(const Piece& piece) { return (at(piece.low) + at(piece.high)) / 2.0; }

  /// A piece's cells [cells] around a place, turned by an angle [rad].
  static std::vector<Eigen::Vector2d> around(const Piece& piece, const Eigen::Vector2d& place, double turn) {
    const Eigen::Rotation2Dd rotation(turn);
    std::vector<Eigen::Vector2d> cells;
    for (const CellIndex cell : piece.cells) cells.push_back(rotation * (at(cell) - place));
    return cells;
  }

  /// Lays cells in a map. @return nothing where they do not fit
  std::optional<Fit> fit(const std::vector<Eigen::Vector2d>& cells, const Eigen::Vector2d& place,
                         const ComparedMap& map) const {
    const auto count = static_cast<double>(cells.size());
    const double may_lack = (1.0 - config_.min_recognised) * count, may_miss = config_.max_missed * count;
    Fit fit;
    int lacking = 0;
    for (const Eigen::Vector2d& cell : cells) {
      const Look look = map.look(
          {static_cast<int>(std::lround(place.x() + cell.x())), static_cast<int>(std::lround(place.y() + cell.y()))});
      fit.recognised += look == Look::kObstacle;
      fit.missed += look == Look::kNone;
      lacking += look != Look::kObstacle;
      if (lacking > may_lack || fit.missed > may_miss) return std::nullopt;
    }
    if (fit.missed > config_.max_missed * (fit.recognised + fit.missed)) return std::nullopt;
    return fit;
  }

  void findTurned(const Piece& a, const Piece& b, double turn, std::optional<Twins>& best) const {
    const Eigen::Vector2d from = middleOf(a);
    const std::vector<Eigen::Vector2d> turned = around(a, from, turn), back = around(b, Eigen::Vector2d::Zero(), -turn);
    Eigen::Vector2d low = turned.front(), high = low;
    for (const Eigen::Vector2d& cell : turned) low = low.cwiseMin(cell), high = high.cwiseMax(cell);
    // Places at which the rectangles around both meet.
    const Eigen::Vector2d reach(distance_, distance_), first = (at(b.low) - high).cwiseMax(from - reach),
                                                       last = (at(b.high) - low).cwiseMin(from + reach);
    const double step = config_.step / config_.cell;
    for (double y = first.y(); y <= last.y(); y += step) {
      for (double x = first.x(); x <= last.x(); x += step) {
        const Eigen::Vector2d to(x, y);
        if ((to - from).squaredNorm() > distance_ * distance_) continue;
        const auto there = fit(turned, to, b_);
        if (!there) continue;
        const auto here = fit(back, from - Eigen::Rotation2Dd(-turn) * to, a_);
        const Twins twins{&a, &b, *there, here.value_or(Fit{})};
        if (here && (!best || twins.score() > best->score())) best = twins;
      }
    }
  }

  const ComparedMap &a_, &b_;
  const MovedFurnitureConfig& config_;
  double distance_;  // [cells]
};

/// Cells of either map whose twins were found.
class Matched {
 public:
  Matched(const ComparedMap& a, const ComparedMap& b) : a_(a), b_(b) {}

  /// Each piece has one twin: the pairs that fit best first. @return [cells] that stand in one map alone, and have one
  double add(const TwinSearch& search, std::span<const double> turns) {
    std::vector<Twins> found;
    for (const Piece& a : a_.pieces()) {
      if (isUsed(used_a_, a)) continue;
      for (const Piece& b : b_.pieces()) {
        if (a.alone + b.alone == 0 || isUsed(used_b_, b)) continue;
        if (const auto twins = search.find(a, b, turns)) found.push_back(*twins);
      }
    }
    std::stable_sort(found.begin(), found.end(), [](const Twins& x, const Twins& y) { return x.score() > y.score(); });
    double cells = 0.0;
    for (const Twins& twins : found) {
      if (isUsed(used_a_, *twins.a) || isUsed(used_b_, *twins.b)) continue;
      cells += use(used_a_, *twins.a, twins.a_in_b) + use(used_b_, *twins.b, twins.b_in_a);
    }
    return cells;
  }

 private:
  using Used = TiledGrid<bool, OccupancyGrid::kTileSide>;

  static bool isUsed(const Used& used, const Piece& piece) {
    return std::any_of(piece.cells.begin(), piece.cells.end(), [&](CellIndex cell) { return used.read(cell); });
  }
  static double use(Used& used, const Piece& piece, const Fit& fit) {
    for (const CellIndex cell : piece.cells) used.cell(cell) = true;
    return piece.alone * fit.recognised / static_cast<double>(piece.cells.size());
  }

  const ComparedMap &a_, &b_;
  Used used_a_, used_b_;
};

}  // namespace

MovedFurniture findMovedFurniture(const OccupancyGrid& grid_a, const OccupancyGrid& grid_b,
                                  const MovedFurnitureConfig& config) {
  ComparedMap a(grid_a, config.compared), b(grid_b, config.compared);
  a.compareWith(b);
  b.compareWith(a);
  const TwinSearch search(a, b, config);
  Matched matched(a, b);
  const double unturned[] = {0.0};
  std::vector<double> turns;
  for (double turn = config.turn; turn < 2.0 * std::numbers::pi - config.turn / 2; turn += config.turn)
    turns.push_back(turn);
  MovedFurniture furniture;
  furniture.moved = config.cell * matched.add(search, unturned);
  furniture.turned = config.cell * matched.add(search, turns);
  furniture.other = std::max(0.0, config.cell * (a.alone() + b.alone()) - furniture.moved - furniture.turned);
  const double counted = furniture.moved + config.turned_weight * furniture.turned;
  furniture.evidence = counted - config.other_weight * (furniture.found() + furniture.other - counted);
  return furniture;
}

}  // namespace slam
