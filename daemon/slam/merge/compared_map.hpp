// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/tiled_grid.hpp"
#include "mapping/occupancy_grid.hpp"

namespace slam {

/// Cells of a map that belong together.
struct Piece {
  std::vector<CellIndex> cells;
  CellIndex low, high;  ///< corners of the rectangle around them, both included
  int alone = 0;        ///< of the cells: those that stand where the other map has seen free floor

  int side() const;  ///< [cells] the longer one of the rectangle
};

struct ComparedMapConfig {
  double tolerance = 0.15;  ///< [m] obstacles of two maps that are no farther apart are the same one
  double blur = 0.05;       ///< [m] by which one obstacle may differ in two maps when it is laid on itself
  double gap = 0.1;         ///< [m] cells that are no farther apart belong to one piece
  double shortest = 0.2;    ///< [m] along x or y: a piece that can be recognised ...
  double longest = 3.0;     ///< [m] ... and a piece of furniture
  double wall = 1.0;        ///< [m] along x or y of obstacles that both maps have: what adjoins them belongs to a wall
};

/// One of two maps of a place that were laid on each other: which of its obstacles the other one does not have.
class ComparedMap {
 public:
  enum class Look : std::uint8_t {
    kUnseen,
    kObstacle,  ///< one that the other map does not have there
    kNone,      ///< free floor, or an obstacle that both have
  };

  explicit ComparedMap(const OccupancyGrid& grid, const ComparedMapConfig& config = {});
  /// @param other of the same frame and cell size
  void compareWith(const ComparedMap& other);

  Look look(CellIndex cell) const;
  bool isAlone(CellIndex cell) const { return (marks_.read(cell) & kAlone) != 0; }
  /// [cells] that stand in this map alone, in pieces that can be recognised.
  int alone() const { return alone_; }
  /// What may have been moved: pieces of obstacles that stand in this map alone, and pieces that the other map does not
  /// have, part of which it may have not seen. A cell may belong to one of either kind.
  const std::vector<Piece>& pieces() const { return pieces_; }

 private:
  enum Mark : std::uint8_t {
    kOccupied = 1,
    kBlurred = 2,      // within the blur of an occupied cell
    kNear = 4,         // within the tolerance of one
    kFree = 8,         // is, or adjoins, a free cell: rays leave holes between them
    kDiffering = 16,   // occupied, and the other map has nothing near
    kAlone = 32,       // of these, where the other map has seen free floor
    kRecognised = 64,  // within the blur of a differing one
    kAtWall = 128,     // adjoins a wall that both maps have
  };
  using Marks = TiledGrid<std::uint8_t, OccupancyGrid::kTileSide>;

  int cellsOf(double metres) const;
  void mark(CellIndex middle, int reach, std::uint8_t marks);
  std::vector<CellIndex> marked(std::uint8_t mark, std::uint8_t without = 0) const;
  std::vector<Piece> connected(std::span<const CellIndex> cells) const;

  ComparedMapConfig config_;
  double resolution_;                // [m]
  std::vector<CellIndex> occupied_;  // row by row within a tile
  Marks marks_;
  std::vector<Piece> pieces_;
  int alone_ = 0;
};

}  // namespace slam
