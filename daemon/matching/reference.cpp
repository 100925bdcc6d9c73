// SPDX-License-Identifier: BSD-3-Clause
#include "matching/reference.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <new>
#include <utility>

namespace slam {
namespace {

constexpr int kBlockShift = 6;  // log2 of the cells to a side of a block that is cleared as one

}  // namespace

Reference::Grid::Grid(double cell, double radius, double extent)
    : inverse_cell(1.0 / cell), reach(static_cast<int>(std::ceil(radius / cell))) {
  const auto side = std::bit_ceil(static_cast<unsigned>(std::ceil(extent / cell)));
  mask = static_cast<int>(side) - 1;
  shift = std::countr_zero(side);
  cells_.reset(static_cast<Id*>(std::calloc(static_cast<std::size_t>(side) * side, sizeof(Id))));
  if (!cells_) throw std::bad_alloc();
  blocks_ = std::max(1, static_cast<int>(side >> kBlockShift));
  touched_.assign(static_cast<std::size_t>(blocks_ * blocks_), 0);
  for (int row = -reach; row <= reach; ++row) {
    int half = -1;
    while (half < reach && std::hypot(half + 1, row) * cell <= radius) ++half;
    half_rows.push_back(half);
  }
  columns.resize(half_rows.size());
}

void Reference::Grid::touch(int column, int row) {
  for (int r = (row - reach) >> kBlockShift; r <= (row + reach) >> kBlockShift; ++r) {
    for (int c = (column - reach) >> kBlockShift; c <= (column + reach) >> kBlockShift; ++c) {
      touched_[static_cast<std::size_t>((r & (blocks_ - 1)) * blocks_ + (c & (blocks_ - 1)))] = 1;
    }
  }
}

void Reference::Grid::clear() {
  const int side = std::min(mask + 1, 1 << kBlockShift);
  for (std::size_t block = 0; block < touched_.size(); ++block) {
    if (!std::exchange(touched_[block], 0)) continue;
    const int row = static_cast<int>(block) / blocks_ * side, column = static_cast<int>(block) % blocks_ * side;
    for (int r = row; r < row + side; ++r) std::fill_n(&at(column, r), side, kNone);
  }
}

void Reference::Grid::forget(std::span<const Surfel> surfels, const Eigen::Vector2d& before, const Eigen::Vector2d& now,
                             double within) {
  const int cells = mask + 1, side = std::min(cells, 1 << kBlockShift);
  const auto stays = [&](int block, double centre_before, double centre_now) {
    const int middle = coordinate(centre_before), far = cells / 2;
    const int offset = ((block * side + side / 2 - middle + far) & mask) - far;  // by the shorter way around the torus
    if (std::abs(offset) > far - side) return false;                             // it may lie on either side
    return (std::abs(middle + offset - coordinate(centre_now)) + side) < within * inverse_cell;
  };
  for (std::size_t block = 0; block < touched_.size(); ++block) {
    const int row = static_cast<int>(block) / blocks_, column = static_cast<int>(block) % blocks_;
    if (!touched_[block] || (stays(column, before.x(), now.x()) && stays(row, before.y(), now.y()))) continue;
    for (int r = row * side; r < (row + 1) * side; ++r) {
      for (Id& id : std::span(&at(column * side, r), static_cast<std::size_t>(side))) {
        if (surfels[static_cast<std::size_t>(id)].observations == 0.0F) id = kNone;
      }
    }
  }
}

void Reference::Grid::takeMemory() {
  const std::size_t page = 2048, size = static_cast<std::size_t>(mask + 1) << shift;  // [cells]; a page is no smaller
  volatile Id* const cells = cells_.get();
  for (std::size_t i = 0; i < size; i += page) cells[i] = cells[i];
  cells[size - 1] = cells[size - 1];  // the first cell need not begin a page
}

Reference::Reference(const ReferenceConfig& config)
    : config_(config),
      fine_(config.fine_cell, config.fine_radius, config.extent),
      coarse_(config.coarse_cell, config.coarse_radius, config.extent),
      half_extent_(0.5 * std::min((fine_.mask + 1) * config.fine_cell, (coarse_.mask + 1) * config.coarse_cell) -
                   config.coarse_radius) {
  config_.max_surfels = std::min(config.max_surfels, ReferenceConfig{}.max_surfels);
  surfels_.reserve(static_cast<std::size_t>(config_.max_surfels) + 1);
  free_.reserve(static_cast<std::size_t>(config_.max_surfels));
  surfels_.emplace_back();
}

void Reference::takeMemory() {
  if (std::exchange(has_memory_, true)) return;
  fine_.takeMemory();
  coarse_.takeMemory();
  const std::size_t surfels = surfels_.size(), free = free_.size();
  surfels_.resize(surfels_.capacity());
  surfels_.resize(surfels);
  free_.resize(free_.capacity());
  free_.resize(free);
}

void Reference::clear(const Eigen::Vector2d& centre) {
  centre_ = centre;
  fine_.clear();
  coarse_.clear();
  surfels_.resize(1);
  free_.clear();
  count_ = 0;
}

void Reference::recentre(const Eigen::Vector2d& centre) {
  if ((centre - centre_).lpNorm<Eigen::Infinity>() < 0.5 * half_extent_) return;
  const Eigen::Vector2d before = std::exchange(centre_, centre);
  // What is so far within its border has no surfel that is forgotten, twice as far none that is hidden by one.
  const double within = half_extent_ - config_.coarse_radius;
  const auto isBeside = [&](const Surfel& surfel) {
    return (Eigen::Vector2d(surfel.x, surfel.y) - centre_).lpNorm<Eigen::Infinity>() > within - config_.coarse_radius;
  };
  for (std::size_t i = 0; i < surfels_.size(); ++i) {
    Surfel& surfel = surfels_[i];
    if (surfel.observations == 0.0F || covers({surfel.x, surfel.y})) continue;
    surfel.observations = 0.0F;
    free_.push_back(static_cast<Id>(i));
    --count_;
  }
  for (Grid* grid : {&fine_, &coarse_}) grid->forget(surfels_, before, centre_, within);
  for (std::size_t i = 0; i < surfels_.size(); ++i) {
    if (surfels_[i].observations == 0.0F || !isBeside(surfels_[i])) continue;
    enter(fine_, static_cast<Id>(i));
    enter(coarse_, static_cast<Id>(i));
  }
}

int Reference::add(const Pose2& T_ref_base, std::span<const ScanPoint> points, const Sensitivity& sensitivity) {
  const PointTransform T(T_ref_base);
  const int before = count_;
  for (const ScanPoint& point : points) {
    const Eigen::Vector2d p = T * point.position, normal = T.turned(point.normal);
    if (!covers(p)) continue;
    const PointShift shift = shiftOf(point, T, sensitivity);
    if (!merge(p, normal, point, shift)) insert(p, normal, point, shift);
  }
  return count_ - before;
}

double Reference::newShare(const Pose2& T_ref_base, std::span<const ScanPoint> points) const {
  const PointTransform T(T_ref_base);
  int covered = 0, met = 0;
  for (const ScanPoint& point : points) {
    const Eigen::Vector2d p = T * point.position;
    if (!covers(p)) continue;
    ++covered;
    met += surfelAt(p, T.turned(point.normal)) != kNone ? 1 : 0;
  }
  return covered > 0 ? 1.0 - static_cast<double>(met) / covered : 0.0;
}

double Reference::freeSpaceViolation(const Pose2& T_ref_base, const RangeImage& scan, double known) const {
  const PointTransform T_base_ref(T_ref_base.inverse());
  VisibilityTally tally;
  for (const Surfel& surfel : surfels()) {
    if (surfel.observations < known) continue;
    const Eigen::Vector2d p = T_base_ref * Eigen::Vector2d(surfel.x, surfel.y);
    tally.add(scan.visibilityOf(p, T_base_ref.turned({surfel.nx, surfel.ny})));
  }
  return tally.visible() < config_.fewest_in_sight ? 0.0 : tally.freeSpaceViolation();
}

/// The surfel of the wall that a point is on, or of its place where either has no line; kNone: of none. A wall takes up
/// the points on no line that are beside it.
Reference::Id Reference::surfelAt(const Eigen::Vector2d& p, const Eigen::Vector2d& normal) const {
  const Id id = fine_.at(p);
  if (id == kNone) return kNone;
  const Surfel& surfel = surfels_[static_cast<std::size_t>(id)];
  const Eigen::Vector2d n(surfel.nx, surfel.ny), d = p - Eigen::Vector2d(surfel.x, surfel.y);
  if (normal.isZero()) return d.norm() > config_.surfel_spacing ? kNone : id;
  if (!surfel.isLine() || n.dot(normal) < config_.same_wall) return kNone;
  const double across = n.dot(d), along = n.x() * d.y() - n.y() * d.x();
  const bool far = std::abs(along) > config_.surfel_spacing || std::abs(across) > config_.merge_distance;
  return far ? kNone : id;
}

bool Reference::merge(const Eigen::Vector2d& p, const Eigen::Vector2d& normal, const ScanPoint& point,
                      const PointShift& shift) {
  const Id id = surfelAt(p, normal);
  if (id == kNone) return false;
  Surfel& surfel = surfels_[static_cast<std::size_t>(id)];
  const Eigen::Vector2d n(surfel.nx, surfel.ny), d = p - Eigen::Vector2d(surfel.x, surfel.y);
  if (normal.isZero()) {
    if (surfel.isLine()) return true;
    const double point_weight = 1.0 / (surfel.observations + 1.0);
    surfel.x += static_cast<float>(point_weight * d.x());
    surfel.y += static_cast<float>(point_weight * d.y());
    surfel.observations = std::min(surfel.observations + 1.0F, static_cast<float>(config_.max_observations));
    surfel.grazing &= point.grazing;
    return true;
  }

  // The mean moves across the wall only: along it the points say nothing, and the spacing stays.
  const double across = n.dot(d), weight = 1.0 / (surfel.observations + 1.0);
  surfel.x += static_cast<float>(weight * across * n.x());
  surfel.y += static_cast<float>(weight * across * n.y());
  for (int i = 0; i < kSystematic; ++i) {
    float& mean = surfel.shift[static_cast<std::size_t>(i)];
    mean += static_cast<float>(weight * (n.dot(shift.col(i)) - mean));
  }
  const double gain = surfel.normal_variance / (surfel.normal_variance + point.normal_variance);
  const Eigen::Vector2d blended = (n + gain * (normal - n)).normalized();
  surfel.nx = static_cast<float>(blended.x());
  surfel.ny = static_cast<float>(blended.y());
  const double floor = point.normal_variance / config_.max_observations;
  surfel.normal_variance = static_cast<float>(std::max(floor, (1.0 - gain) * surfel.normal_variance));
  surfel.observations = std::min(surfel.observations + 1.0F, static_cast<float>(config_.max_observations));
  return true;
}

void Reference::insert(const Eigen::Vector2d& p, const Eigen::Vector2d& normal, const ScanPoint& point,
                       const PointShift& shift) {
  Id id = kNone;
  if (!free_.empty()) {
    id = free_.back();
    free_.pop_back();
  } else if (static_cast<int>(surfels_.size()) <= config_.max_surfels) {
    id = static_cast<Id>(surfels_.size());
    surfels_.emplace_back();
  } else {
    return;
  }
  surfels_[static_cast<std::size_t>(id)] = {static_cast<float>(p.x()),
                                            static_cast<float>(p.y()),
                                            static_cast<float>(normal.x()),
                                            static_cast<float>(normal.y()),
                                            static_cast<float>(point.normal_variance),
                                            1.0F,
                                            point.grazing};
  for (int i = 0; i < kSystematic; ++i)
    surfels_[static_cast<std::size_t>(id)].shift[static_cast<std::size_t>(i)] =
        static_cast<float>(normal.dot(shift.col(i)));
  ++count_;
  enter(fine_, id);
  enter(coarse_, id);
}

void Reference::enter(Grid& grid, Id id) {
  const Surfel& surfel = surfels_[static_cast<std::size_t>(id)];
  const int column = grid.coordinate(surfel.x), row = grid.coordinate(surfel.y);
  const double cell = 1.0 / grid.inverse_cell;
  if (cell > config_.surfel_spacing) {  // one surfel a cell is as good as many
    const Id there = grid.at(column, row);
    const bool taken = there != kNone && there != id &&
                       grid.coordinate(surfels_[static_cast<std::size_t>(there)].x) == column &&
                       grid.coordinate(surfels_[static_cast<std::size_t>(there)].y) == row;
    if (taken) return;
  }
  grid.touch(column, row);
  for (int i = -grid.reach; i <= grid.reach; ++i) {
    const double x = (column + i + 0.5) * cell;
    grid.columns[static_cast<std::size_t>(i + grid.reach)] = {x, (surfel.x - x) * (surfel.x - x)};
  }
  // What a cell that is written might change, as far as the compiler knows.
  const int mask = grid.mask, reach = grid.reach;
  const Surfel* const surfels = surfels_.data();
  const Grid::Column* const columns = &grid.columns[static_cast<std::size_t>(reach)];
  for (int i = -reach; i <= reach; ++i) {
    const double y = (row + i + 0.5) * cell, across = (surfel.y - y) * (surfel.y - y);
    const int half = grid.half_rows[static_cast<std::size_t>(i + reach)];
    Id* const cells = &grid.at(0, row + i);
    for (int k = -half; k <= half;) {  // once, or twice where the torus closes
      Id* occupant = &cells[(column + k) & mask];
      const int end = std::min(half + 1, k + static_cast<int>(&cells[mask] - occupant) + 1);
      for (; k < end; ++k, ++occupant) {
        const auto& [x, along] = columns[k];
        if (*occupant != kNone) {
          const Surfel& other = surfels[*occupant];
          const double theirs = (other.x - x) * (other.x - x) + (other.y - y) * (other.y - y);
          if (theirs <= along + across) continue;
        }
        *occupant = id;
      }
    }
  }
}

}  // namespace slam
