// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

#include "core/pose2.hpp"
#include "core/pose_covariance.hpp"
#include "matching/range_image.hpp"
#include "matching/scan_points.hpp"

namespace slam {

struct ReferenceConfig {
  double extent = 102.4;       ///< [m] side of the square kept around the robot; rounded up to a power of two of cells
  double fine_cell = 0.05;     ///< [m] of the table used near convergence
  double fine_radius = 0.25;   ///< [m] it knows the nearest surfel up to here
  double coarse_cell = 0.20;   ///< [m] of the table used while the guess is still far
  double coarse_radius = 2.0;  ///< [m] it knows the nearest surfel up to here
  double surfel_spacing = 0.05;  ///< [m] points closer than this along a wall are one surfel
  double merge_distance = 0.08;  ///< [m] and closer than this across it
  int max_observations = 100;    ///< weight of a surfel's past: more makes the reference stiffer
  int max_surfels = UINT16_MAX;  ///< memory bound: no more has an entry of the tables room for
  int fewest_in_sight = 20;      ///< surfels that tell a place
  double same_wall = 0.6;        ///< cosine: normals within 53 degrees may be one wall

  void visitSettings(auto& v) {
    v.expert("max_observations", max_observations, "", 1, 1000000,
             "A surfel of the local map averages this many observations; a higher number makes the local map stiffer.");
    v.expert("surfel_spacing", surfel_spacing, "m", 0.01, 1.0,
             "Points that are closer than this along a wall become one surfel.");
    v.expert("merge_distance", merge_distance, "m", 0.01, 1.0,
             "Points that are closer than this across a wall become one surfel.");
  }
};

/// A piece of wall: mean of the points seen there, with its line.
struct Surfel {
  float x = 0.0F, y = 0.0F;                   ///< [m] in the reference frame
  float nx = 0.0F, ny = 0.0F;                 ///< unit normal, towards free space
  float normal_variance = 0.0F;               ///< [rad^2]
  float observations = 0.0F;                  ///< points merged, at most max_observations
  bool grazing = false;                       ///< as every point merged might
  std::array<float, kSystematic> shift = {};  ///< [units] across the line, by systematic errors of one unit each
  bool isLine() const { return nx * nx + ny * ny > 0.0F; }
};

/// The fixed set that scans are matched against: surfels of the keyframes around the robot, with two look-up tables
/// that hold, for each cell, the surfel nearest to the cell's centre. A look-up costs one table access whatever the
/// size.
///
/// The tables are tori over a square window that follows the robot: moving it clears the strips that leave it. Memory
/// is taken at construction; nothing allocates afterwards. Of the tables the system gives the pages where there are
/// walls, at their first use, unless takeMemory() was called.
class Reference {
 public:
  explicit Reference(const ReferenceConfig& config = {});

  /// Takes all its memory from the system now, so that no first use makes a real-time thread wait. Once is enough.
  void takeMemory();
  /// Forgets all surfels and puts the window around `centre`.
  void clear(const Eigen::Vector2d& centre = Eigen::Vector2d::Zero());
  /// Moves the window when `centre` has left its middle half. Surfels that leave it are forgotten.
  void recentre(const Eigen::Vector2d& centre);
  /// Adds points; merges those that meet a surfel of the same wall, or of the same place where there is no line.
  /// @return number of new surfels
  /// @param sensitivity of the pose, in the reference
  int add(const Pose2& T_ref_base, std::span<const ScanPoint> points,
          const Sensitivity& sensitivity = Sensitivity::Zero());

  /// Share of a scan's points that no surfel's wall is at, 0..1: what add() would draw anew.
  double newShare(const Pose2& T_ref_base, std::span<const ScanPoint> points) const;

  /// @param reach [m] how far to look; beyond fine_radius the coarse table is asked too, and no further than its radius
  /// @return the surfel nearest to p, give or take half a cell of the table that answers, or nullptr
  const Surfel* nearest(const Eigen::Vector2d& p, double reach) const {
    Id id = fine_.at(p);
    if (id == kNone && reach > config_.fine_radius) id = coarse_.at(p);
    return id == kNone ? nullptr : &surfels_[static_cast<std::size_t>(id)];
  }

  /// Share of the surfels in sight that a scan sees through instead of meeting them [1]; 0 where few are in sight.
  /// @param known surfels that were observed so often
  double freeSpaceViolation(const Pose2& T_ref_base, const RangeImage& scan, double known) const;

  /// Whether a point is in the window: elsewhere nothing is known, or can be.
  bool covers(const Eigen::Vector2d& p) const {
    return std::abs(p.x() - centre_.x()) < half_extent_ && std::abs(p.y() - centre_.y()) < half_extent_;
  }
  /// Includes forgotten ones: observations == 0.
  std::span<const Surfel> surfels() const { return std::span(surfels_).subspan(1); }
  int size() const { return count_; }
  const ReferenceConfig& config() const { return config_; }

 private:
  using Id = std::uint16_t;       // of a surfel
  static constexpr Id kNone = 0;  // one that is always forgotten
  struct Grid {
    double inverse_cell;         // [1/m]
    int mask;                    // side - 1, side a power of two
    int shift;                   // log2(side)
    int reach;                   // [cells] of the disc of cells within the radius
    std::vector<int> half_rows;  // [cells] of the disc's rows, to either side of its middle
    struct Column {
      double x, mine;  // [m], and squared from the surfel that is entered
    };
    std::vector<Column> columns;  // of the disc

    Grid(double cell, double radius, double extent);
    int coordinate(double metres) const {  // floor(), which is a call where SSE4.1 may not be used
      const int positive = 1 << 28;        // [cells] truncation rounds down there
      return static_cast<int>(metres * inverse_cell + positive) - positive;
    }
    Id& at(int column, int row) { return cells_[index(column, row)]; }
    Id at(const Eigen::Vector2d& p) const { return cells_[index(coordinate(p.x()), coordinate(p.y()))]; }
    /// Before a disc is written around a cell.
    void touch(int column, int row);
    void clear();
    /// Empties the cells of surfels that are forgotten. @param within [m] of the window's middle `now`: there are none
    void forget(std::span<const Surfel> surfels, const Eigen::Vector2d& before, const Eigen::Vector2d& now,
                double within);
    void takeMemory();

   private:
    struct Free {
      void operator()(void* memory) const { std::free(memory); }
    };
    std::size_t index(int column, int row) const {
      return (static_cast<std::size_t>(row & mask) << shift) | static_cast<std::size_t>(column & mask);
    }
    std::unique_ptr<Id[], Free> cells_;  // of zeroed pages, which are not there until they are written
    int blocks_;                         // to a side
    std::vector<char> touched_;          // blocks that clear() clears
  };

  Id surfelAt(const Eigen::Vector2d& p, const Eigen::Vector2d& normal) const;
  bool merge(const Eigen::Vector2d& p, const Eigen::Vector2d& normal, const ScanPoint& point, const PointShift& shift);
  void insert(const Eigen::Vector2d& p, const Eigen::Vector2d& normal, const ScanPoint& point, const PointShift& shift);
  void enter(Grid& grid, Id id);

  ReferenceConfig config_;
  Grid fine_, coarse_;
  double half_extent_;
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();
  std::vector<Surfel> surfels_;
  std::vector<Id> free_;
  int count_ = 0;
  bool has_memory_ = false;  // all of it, from the system
};

}  // namespace slam
