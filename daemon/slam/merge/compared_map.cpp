// SPDX-License-Identifier: BSD-3-Clause
#include "slam/merge/compared_map.hpp"

#include <algorithm>
#include <cmath>

namespace slam {

int Piece::side() const { return std::max(high.column - low.column, high.row - low.row); }

ComparedMap::ComparedMap(const OccupancyGrid& grid, const ComparedMapConfig& config)
    : config_(config), resolution_(grid.resolution()) {
  constexpr int kSide = OccupancyGrid::kTileSide;
  grid.tiles().forEachTile([&](TileIndex tile, const OccupancyGrid::Tiles::Tile& cells) {
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        const LogOdds log_odds = grid.fused(cells.at(column, row));
        const CellIndex cell{tile.column * kSide + column, tile.row * kSide + row};
        if (log_odds > 0) occupied_.push_back(cell);
        if (log_odds < 0) mark(cell, 1, kFree);
      }
    }
  });
  for (const CellIndex cell : occupied_) {
    mark(cell, 0, kOccupied);
    mark(cell, cellsOf(config_.blur), kBlurred);
    mark(cell, cellsOf(config_.tolerance), kNear);
  }
}

int ComparedMap::cellsOf(double metres) const { return static_cast<int>(std::lround(metres / resolution_)); }

void ComparedMap::mark(CellIndex middle, int reach, std::uint8_t marks) {
  for (int row = middle.row - reach; row <= middle.row + reach; ++row) {
    for (int column = middle.column - reach; column <= middle.column + reach; ++column)
      marks_.cell({column, row}) |= marks;
  }
}

std::vector<CellIndex> ComparedMap::marked(std::uint8_t mark, std::uint8_t without) const {
  std::vector<CellIndex> cells;
  std::copy_if(occupied_.begin(), occupied_.end(), std::back_inserter(cells), [&](CellIndex cell) {
    const std::uint8_t marks = marks_.read(cell);
    return (marks & mark) != 0 && (marks & without) == 0;
  });
  return cells;
}

std::vector<Piece> ComparedMap::connected(std::span<const CellIndex> cells) const {
  const int reach = cellsOf(config_.gap);
  Marks open;
  for (const CellIndex cell : cells) open.cell(cell) = 1;
  std::vector<Piece> pieces;
  for (const CellIndex first : cells) {
    if (open.read(first) == 0) continue;
    open.cell(first) = 0;
    Piece piece{.cells = {first}, .low = first, .high = first};
    for (std::size_t i = 0; i < piece.cells.size(); ++i) {
      const CellIndex here = piece.cells[i];
      piece.low = {std::min(piece.low.column, here.column), std::min(piece.low.row, here.row)};
      piece.high = {std::max(piece.high.column, here.column), std::max(piece.high.row, here.row)};
      for (int row = here.row - reach; row <= here.row + reach; ++row) {
        for (int column = here.column - reach; column <= here.column + reach; ++column) {
          const CellIndex next{column, row};
          if (open.read(next) == 0) continue;
          open.cell(next) = 0;
          piece.cells.push_back(next);
        }
      }
    }
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

void ComparedMap::compareWith(const ComparedMap& other) {
  for (const CellIndex cell : occupied_) {
    const std::uint8_t there = other.marks_.read(cell);
    if ((there & kNear) != 0) continue;
    mark(cell, 0, (there & kFree) != 0 ? kDiffering | kAlone : kDiffering);
    mark(cell, cellsOf(config_.blur), kRecognised);
  }
  for (const Piece& fixed : connected(marked(kOccupied, kDiffering))) {
    if (fixed.side() < cellsOf(config_.wall)) continue;
    for (const CellIndex cell : fixed.cells) mark(cell, cellsOf(config_.gap), kAtWall);
  }
  const int shortest = cellsOf(config_.shortest), longest = cellsOf(config_.longest);
  pieces_ = connected(marked(kAlone));
  std::erase_if(pieces_, [&](const Piece& piece) { return piece.side() < shortest; });
  alone_ = 0;
  for (const Piece& piece : pieces_) alone_ += static_cast<int>(piece.cells.size());
  for (Piece& piece : connected(marked(kDiffering))) {
    const auto atWall = [&](CellIndex cell) { return (marks_.read(cell) & kAtWall) != 0; };
    if (piece.side() >= shortest && piece.side() < longest &&
        std::none_of(piece.cells.begin(), piece.cells.end(), atWall))
      pieces_.push_back(std::move(piece));
  }
  for (Piece& piece : pieces_)
    piece.alone = static_cast<int>(
        std::count_if(piece.cells.begin(), piece.cells.end(), [&](CellIndex cell) { return isAlone(cell); }));
}

ComparedMap::Look ComparedMap::look(CellIndex cell) const {
  const std::uint8_t marks = marks_.read(cell);
  if ((marks & kRecognised) != 0) return Look::kObstacle;
  const bool free = (marks & (kFree | kBlurred)) == kFree, in_both = (marks & kOccupied) != 0;
  return free || in_both ? Look::kNone : Look::kUnseen;
}

}  // namespace slam
