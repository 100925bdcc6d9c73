// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <slam/map_meta_t.hpp>
#include <slam/map_tile_t.hpp>
#include <string>
#include <utility>

#include "core/pose2.hpp"

namespace slam {

/// The newest tiles of a map, as one picture.
class MapPicture {
 public:
  struct Picture {
    std::int64_t utime;          ///< [us since the epoch]
    Pose2 corner;                ///< lower left one in map
    double resolution;           ///< [m]
    std::int64_t columns, rows;  ///< [cells]
    std::string cells;           ///< row by row from the lower left: occupancy in percent, 255 unknown
  };

  void add(const map_meta_t& meta) {
    if (meta.map_id != meta_.map_id) tiles_.clear();
    meta_ = meta;
    known_ = true;
  }
  void add(const map_tile_t& tile) {
    if (known_ && tile.map_id != meta_.map_id) return;
    tiles_[{tile.column, tile.row}] = tile;
    changed_ = true;
  }
  bool due(std::int64_t now) const { return changed_ && known_ && now - drawn_ >= kMapPeriod; }

  /// @return nullopt: there is nothing to draw
  std::optional<Picture> draw(std::int64_t now) {
    drawn_ = now;
    changed_ = false;
    const std::int64_t side = meta_.tile_side;
    std::int64_t first_column = INT32_MAX, last_column = INT32_MIN, first_row = INT32_MAX, last_row = INT32_MIN;
    for (const auto& [place, tile] : tiles_) {
      first_column = std::min<std::int64_t>(first_column, place.first);
      last_column = std::max<std::int64_t>(last_column, place.first);
      first_row = std::min<std::int64_t>(first_row, place.second);
      last_row = std::max<std::int64_t>(last_row, place.second);
    }
    if (tiles_.empty() || side < 1 || !(meta_.resolution > 0.0)) return std::nullopt;
    const double wide = static_cast<double>(last_column - first_column + 1) * static_cast<double>(side);
    const double high = static_cast<double>(last_row - first_row + 1) * static_cast<double>(side);
    if (wide * high > static_cast<double>(kMostCells)) return std::nullopt;
    const std::int64_t columns = (last_column - first_column + 1) * side, rows = (last_row - first_row + 1) * side;
    std::string cells(static_cast<std::size_t>(columns * rows), '\xFF');
    for (const auto& [place, tile] : tiles_) {
      if (tile.side != side) continue;
      const std::int64_t column = (place.first - first_column) * side, row = (place.second - first_row) * side;
      for (std::int64_t r = 0; r < side; ++r) {
        std::memcpy(&cells[static_cast<std::size_t>((row + r) * columns + column)],
                    &tile.cells[static_cast<std::size_t>(r * side)], static_cast<std::size_t>(side));
      }
    }
    const double metres = meta_.resolution * static_cast<double>(side);
    return Picture{meta_.utime,
                   {meta_.origin[0] + metres * static_cast<double>(first_column),
                    meta_.origin[1] + metres * static_cast<double>(first_row), 0.0},
                   meta_.resolution,
                   columns,
                   rows,
                   std::move(cells)};
  }

 private:
  static constexpr std::int64_t kMapPeriod = 2'000'000;  // [us] between pictures of the whole map
  static constexpr std::int64_t kMostCells = 1 << 26;    // of such a picture

  map_meta_t meta_{};
  bool known_ = false, changed_ = false;
  std::int64_t drawn_ = 0;  // [us]
  std::map<std::pair<std::int32_t, std::int32_t>, map_tile_t> tiles_;
};

}  // namespace slam
