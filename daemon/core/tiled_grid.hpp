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

/// A grid without borders, made of square tiles that are allocated where something is written. They are found by a hash
/// of their address, so that memory follows what is drawn, however far apart it lies. Growing moves pointers, never
/// cells.
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
  const Tile* find(TileIndex tile) const { return places_.empty() ? nullptr : places_[slot(tile)].tile.get(); }
  Tile* find(TileIndex tile) { return const_cast<Tile*>(std::as_const(*this).find(tile)); }

  /// @return the tile, made if missing
  Tile& make(TileIndex tile) {
    auto& content = place(tile);
    if (!content) {
      content = std::make_unique<Tile>();
      ++count_;
    }
    return *content;
  }

  /// Puts a tile in the place of the one there, if any.
  void put(TileIndex tile, std::unique_ptr<Tile> content) {
    auto& before = place(tile);
    count_ += !before;
    before = std::move(content);
  }
  /// Calls take(TileIndex, std::unique_ptr<Tile>) for each tile, row by row from the lower left, and is empty then.
  template <typename Take>
  void takeTiles(Take&& take) {
    for (const std::size_t i : rowByRow()) take(places_[i].index, std::move(places_[i].tile));
    clear();
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
    for (const std::size_t i : rowByRow()) visit(places_[i].index, *places_[i].tile);
  }

  /// A copy of all tiles: never by accident.
  TiledGrid clone() const {
    TiledGrid copy;
    copy.count_ = count_;
    for (const Place& place : places_)
      copy.places_.push_back({place.index, place.tile ? std::make_unique<Tile>(*place.tile) : nullptr});
    return copy;
  }

  int tileCount() const { return count_; }
  void clear() { *this = TiledGrid(); }

 private:
  struct Place {
    TileIndex index;
    std::unique_ptr<Tile> tile;  // nullptr: the place is free
  };
  static int floorDivide(int value) { return value >> std::countr_zero(static_cast<unsigned>(kSide)); }

  /// Where a tile is, or would be. @pre there are places
  std::size_t slot(TileIndex tile) const {
    const std::uint64_t address = static_cast<std::uint64_t>(static_cast<std::uint32_t>(tile.row)) << 32U |
                                  static_cast<std::uint32_t>(tile.column);
    const std::size_t mask = places_.size() - 1;
    std::size_t i = (address * 0x9E3779B97F4A7C15U) >> 32U & mask;  // Fibonacci hashing [Knuth, TAOCP 3, 6.4]
    while (places_[i].tile && places_[i].index != tile) i = (i + 1) & mask;
    return i;
  }

  /// The same, with room for it.
  std::unique_ptr<Tile>& place(TileIndex tile) {
    if (2 * static_cast<std::size_t>(count_) >= places_.size()) {  // half of them stay free
      std::vector<Place> before(std::max<std::size_t>(16, 2 * places_.size()));
      std::swap(before, places_);
      for (Place& old : before) {
        if (old.tile) places_[slot(old.index)] = std::move(old);
      }
    }
    Place& found = places_[slot(tile)];
    found.index = tile;
    return found.tile;
  }

  std::vector<std::size_t> rowByRow() const {
    std::vector<std::size_t> order;
    order.reserve(static_cast<std::size_t>(count_));
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (places_[i].tile) order.push_back(i);
    }
    std::sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
      const TileIndex &first = places_[a].index, &second = places_[b].index;
      return first.row != second.row ? first.row < second.row : first.column < second.column;
    });
    return order;
  }

  int count_ = 0;
  std::vector<Place> places_;  // a power of two, probed linearly
};

}  // namespace slam
