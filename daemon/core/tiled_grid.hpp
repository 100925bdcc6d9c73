// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace slam {

/// Address of a grid cell: column grows with x, row with y; cell (0, 0) has its lower-left corner at the grid's origin.
struct CellIndex {
  int column = 0;
  int row = 0;
  friend bool operator==(const CellIndex&, const CellIndex&) = default;
};

/// Address of a tile; tile (0, 0) begins at cell (0, 0).
struct TileIndex {
  int column = 0;
  int row = 0;
  friend bool operator==(const TileIndex&, const TileIndex&) = default;
};

/// A grid without borders, made of square tiles that are allocated where something is written. Growing moves pointers,
/// never cells.
template <typename Cell, int kSide>
class TiledGrid {
 public:
  static_assert((kSide & (kSide - 1)) == 0, "the side of a tile is a power of two");
  static constexpr int kTileSide = kSide;
  struct Tile {
    std::array<Cell, static_cast<std::size_t>(kSide) * kSide> cells{};  ///< row by row, from the lower left
    Cell& at(int column, int row) { return cells[static_cast<std::size_t>(row * kSide + column)]; }
    const Cell& at(int column, int row) const { return cells[static_cast<std::size_t>(row * kSide + column)]; }
  };

  static TileIndex tileOf(CellIndex cell) { return {floorDivide(cell.column), floorDivide(cell.row)}; }

  /// @return the tile, or nullptr where nothing was written yet
  const Tile* find(TileIndex tile) const {
    const int c = tile.column - first_.column, r = tile.row - first_.row;
    if (c < 0 || r < 0 || c >= columns_ || r >= rows_) return nullptr;
    return directory_[static_cast<std::size_t>(r * columns_ + c)].get();
  }
  Tile* find(TileIndex tile) { return const_cast<Tile*>(std::as_const(*this).find(tile)); }

  /// @return the tile, made if missing
  Tile& make(TileIndex tile) {
    grow(tile);
    auto& place = directory_[slot(tile)];
    if (!place) {
      place = std::make_unique<Tile>();
      ++count_;
    }
    return *place;
  }

  /// Takes a tile out; nullptr where there is none.
  std::unique_ptr<Tile> take(TileIndex tile) {
    if (find(tile) == nullptr) return nullptr;
    --count_;
    return std::move(directory_[slot(tile)]);
  }
  /// Puts a tile in the place of the one there, if any.
  void put(TileIndex tile, std::unique_ptr<Tile> content) {
    make(tile);
    directory_[slot(tile)] = std::move(content);
  }

  Cell& cell(CellIndex index) { return make(tileOf(index)).at(index.column & (kSide - 1), index.row & (kSide - 1)); }
  /// @return the cell, or a default one where nothing was written yet
  Cell read(CellIndex index) const {
    const Tile* tile = find(tileOf(index));
    return tile ? tile->at(index.column & (kSide - 1), index.row & (kSide - 1)) : Cell{};
  }

  /// Calls visit(TileIndex, const Tile&) for each tile, row by row from the lower left.
  template <typename Visit>
  void forEachTile(Visit&& visit) const {
    for (int r = 0; r < rows_; ++r) {
      for (int c = 0; c < columns_; ++c) {
        const auto& tile = directory_[static_cast<std::size_t>(r * columns_ + c)];
        if (tile) visit(TileIndex{c + first_.column, r + first_.row}, *tile);
      }
    }
  }

  /// A copy of all tiles: never by accident.
  TiledGrid clone() const {
    TiledGrid copy;
    copy.first_ = first_, copy.columns_ = columns_, copy.rows_ = rows_, copy.count_ = count_;
    for (const auto& tile : directory_) copy.directory_.push_back(tile ? std::make_unique<Tile>(*tile) : nullptr);
    return copy;
  }

  int tileCount() const { return count_; }
  void clear() { *this = TiledGrid(); }

 private:
  std::size_t slot(TileIndex tile) const {
    return static_cast<std::size_t>((tile.row - first_.row) * columns_ + tile.column - first_.column);
  }
  static int floorDivide(int value) { return value >> std::countr_zero(static_cast<unsigned>(kSide)); }

  void grow(TileIndex tile) {
    if (columns_ == 0) {
      first_ = tile;
      columns_ = rows_ = 1;
      directory_.resize(1);
      return;
    }
    const int left = std::min(first_.column, tile.column), bottom = std::min(first_.row, tile.row);
    const int right = std::max(first_.column + columns_, tile.column + 1);
    const int top = std::max(first_.row + rows_, tile.row + 1);
    if (right - left == columns_ && top - bottom == rows_) return;
    std::vector<std::unique_ptr<Tile>> grown(static_cast<std::size_t>(right - left) * (top - bottom));
    for (int r = 0; r < rows_; ++r) {
      for (int c = 0; c < columns_; ++c) {
        const int to = (r + first_.row - bottom) * (right - left) + c + first_.column - left;
        grown[static_cast<std::size_t>(to)] = std::move(directory_[static_cast<std::size_t>(r * columns_ + c)]);
      }
    }
    directory_ = std::move(grown);
    first_ = {left, bottom};
    columns_ = right - left;
    rows_ = top - bottom;
  }

  TileIndex first_;
  int columns_ = 0, rows_ = 0, count_ = 0;
  std::vector<std::unique_ptr<Tile>> directory_;  // row by row over the bounding box of all tiles
};

}  // namespace slam
